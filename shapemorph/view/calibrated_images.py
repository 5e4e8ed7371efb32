"""Both flattened shapes and the morphed one, with the points that were followed."""

from typing import TYPE_CHECKING

from shapemorph.core.flattened import FlattenedPair
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.morphed import Morphed
from shapemorph.core.status import PointStatus
from shapemorph.view.layout import Heading
from shapemorph.view.panels import draw_photograph, sheet
from shapemorph.view.plots import even_selection
from shapemorph.view.style import DEFORMED_COLOUR

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ACROSS = 30
"""Points across a picture that are drawn."""


def calibrated_figure(pair: FlattenedPair, morphed: Morphed, grid: CorrelationGrid) -> "Figure":
    """Draw the flattened shapes and the morphed one with the points of the grid."""
    ok = grid.status == PointStatus.OK
    some = even_selection(grid.reference_px[ok], ACROSS)
    before, after = grid.reference_px[ok][some], grid.deformed_px[ok][some]
    pictures = [
        ("deformed", pair.deformed.calibrated.image.grey, after),
        ("deformed, morphed by the law", morphed.image.grey, before),
        ("undeformed", pair.reference.calibrated.image.grey, before),
    ]
    heading = Heading("Calibrated images", "every pixel knows its place in space; some points")
    figure, axes = sheet([title for title, _, _ in pictures], 3, heading)
    for own, (_, picture, points) in zip(axes, pictures, strict=True):
        draw_photograph(own, picture)
        own.plot(points[:, 0], points[:, 1], ".", color=DEFORMED_COLOUR, markersize=2.0)
    return figure
