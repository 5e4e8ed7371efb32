"""Colour bars: a strip of colours, arrows where values lie beyond, numbers, a label."""

from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.methods.colour_maps import colour_table
from shapemorph.view.rulers import Box, Ruler, share_of, write_at
from shapemorph.view.style import INK, SMALL, TEXT, ColourScale, place_pixels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from shapemorph.view.window import Pixels

ARROW = 0.03
"""Length of an arrow, share of the bar."""
STEPS, AWAY = 8, 9.0
"""Steps between its numbers, at most; room between these and the label, px."""


def draw_colour_bar(figure: "Figure", box: Box, scale: ColourScale, label: str) -> None:
    """Draw an upright colour bar into a box of the figure; its words stand to the right."""
    left, top, width, height = box
    over, under = scale.beyond in ("max", "both"), scale.beyond in ("min", "both")
    arrow = ARROW * height
    top, height = top + over * arrow, height - (over + under) * arrow
    table = colour_table(scale.name)
    if over:
        _draw_arrow(figure, (left, top, width, -arrow), table[-1] / 255)
    if under:
        _draw_arrow(figure, (left, top + height, width, arrow), table[0] / 255)

    def strip(ratio: int) -> "Pixels":
        rows = max(1, round(height * ratio))
        entries = ((np.arange(rows)[::-1] + 0.5) / rows * len(table)).astype(np.int64)
        return np.repeat(table[entries][:, None], max(1, round(width * ratio)), axis=1)

    place_pixels(figure, round(left), round(top), strip)
    ruler = Ruler("right", scale.high, scale.low, STEPS, SMALL, INK)
    room = ruler.draw(figure, (left, top, width, height))
    place = np.array([left + width + room + AWAY, top + height / 2])
    text = write_at(figure, place, label, size=TEXT, colour=INK)
    text.set(va="center", rotation=90)


def _draw_arrow(figure: "Figure", box: Box, colour: Floats) -> None:
    """Fill a triangle on a side of a bar; its height is negative where it points up."""
    from matplotlib.patches import Polygon

    left, base, width, height = box
    corners = np.array([[left, base], [left + width, base], [left + width / 2, base + height]])
    patch = Polygon(share_of(figure, corners), facecolor=tuple(colour), linewidth=0)
    patch.set_transform(figure.transFigure)
    figure.add_artist(patch)
