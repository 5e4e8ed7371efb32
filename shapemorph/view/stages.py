"""The stages of image-morphing in one figure, from the masks to the grids on both originals."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Matches, Warp
from shapemorph.methods.densify import grid_points
from shapemorph.methods.warping import warp_points
from shapemorph.view.layout import Heading
from shapemorph.view.panels import draw_photograph, draw_points, sheet
from shapemorph.view.plots import even_selection
from shapemorph.view.style import DEFORMED_COLOUR, REFERENCE_COLOUR

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SURFACE_ACROSS = 90
"""Points across a picture at which the surface through the disparities is drawn."""
GRID_ACROSS = 30
"""Points across a picture that are drawn of a grid."""


def stages_figure(
    pictures: Sequence[GreyImage],
    matches: Matches,
    warps: tuple[Warp, Warp],
    grids: tuple[Floats, Floats, Floats, Floats],
) -> "Figure":
    """Draw how two pictures are bridged.

    First the matched points of both, with the outline of a mask that leaves something out, and
    their disparities; then the surfaces through these, forth and back; then the
    pictures I1 to IN, with the grid on both in the middle and where it was carried to.

    Parameters
    ----------
    pictures : sequence of N GreyImage
        N even; both originals at the ends.
    matches : Matches
    warps : two Warp
        Forward and backward, through the matched points.
    grids : four (P, 2) arrays
        On the first picture, on both in the middle and on the last, px; the two at the ends may
        have fewer points.

    References
    ----------
    .. [1] Genovese, K. and Sorgente, D. (2017). A morphing-based scheme for large
       deformation analysis with stereo-DIC. Optics and Lasers in Engineering, Fig. 2.
       :doi:`10.1016/j.optlaseng.2017.06.020`
    """
    titles = ["mask and matched points, first", "matched points, second"]
    titles += ["du of matched points", "dv of matched points"]
    titles += ["du, forward", "dv, forward", "du, backward", "dv, backward"]
    titles += [f"I{k + 1}" for k in range(len(pictures))]
    note = f"{len(matches.reference_px)} pairs, found from features; the grid starts in the middle"
    figure, axes = sheet(titles, 4, Heading("Stages of image-morphing, last state", note))
    ends = (pictures[0], matches.reference_px), (pictures[-1], matches.deformed_px)
    for own, (image, points) in zip(axes, ends, strict=False):
        draw_photograph(own, image.grey)
        _draw_outline(own, image.mask)
        own.plot(points[:, 0], points[:, 1], ".", color=DEFORMED_COLOUR, markersize=1.0)
    shift = matches.deformed_px - matches.reference_px
    _draw_disparities(figure, axes[2:4], matches.reference_px, shift)
    for k, (warp, (image, points)) in enumerate(zip(warps, ends, strict=True)):
        at = _between(image, points)
        moved = warp_points(warp, at)[0] - at
        _draw_disparities(figure, axes[4 + 2 * k : 6 + 2 * k], at, moved)
    for own, image in zip(axes[8:], pictures, strict=True):
        draw_photograph(own, image.grey)
    half = 8 + len(pictures) // 2
    places = (axes[8], axes[half - 1], axes[half], axes[-1])
    for own, grid in zip(places, grids, strict=True):
        some = grid[even_selection(grid, GRID_ACROSS)]
        own.plot(some[:, 0], some[:, 1], "+", color=REFERENCE_COLOUR, markersize=2.5)
    return figure


def _between(image: GreyImage, points: Floats) -> Floats:
    """Regular grid (N, 2) on the mask, between some points and not beyond them."""
    from scipy.spatial import Delaunay

    at = grid_points(image.mask, max(image.shape) / SURFACE_ACROSS)
    between: Floats = at[Delaunay(points).find_simplex(at) >= 0]
    return between


def _draw_outline(axes: "Axes", mask: Bools) -> None:
    """Draw the border of a mask that leaves something out."""
    if not mask.all():
        axes.contour(mask, levels=(0.5,), colors=REFERENCE_COLOUR, linewidths=1.0)


def _draw_disparities(figure: "Figure", axes: Sequence["Axes"], at: Floats, shift: Floats) -> None:
    """Colour points (N, 2) by both components of their shift, y down as in a picture."""
    for own, values in zip(axes, shift.T, strict=True):
        draw_points(figure, own, at, values, "px")
        own.invert_yaxis()
