"""Figures of several panels."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from shapemorph.core.arrays import Floats, Greys
from shapemorph.view.colour_bar import draw_colour_bar
from shapemorph.view.layout import BAR, EDGE, HEAD, Heading, write_heading
from shapemorph.view.style import (
    FAINT,
    SMALL,
    ColourScale,
    colour_scale,
    new_figure,
    place_axes,
    reduced,
    write_text,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL, BESIDE, BELOW = 340, 180, 90
"""Side of a panel, room beside it for a colour bar, below it for its axis, px."""
PICTURE = 900
"""Longest side of a photograph in a figure, px."""


def sheet(titles: Sequence[str], columns: int, heading: Heading) -> "tuple[Figure, list[Axes]]":
    """Make a figure of panels with their titles."""
    rows = -(-len(titles) // columns)
    across, down = PANEL + BESIDE, PANEL + BELOW
    figure = new_figure(EDGE + columns * across, HEAD + rows * down + EDGE)
    write_heading(figure, heading)
    axes = []
    for k, title in enumerate(titles):
        left = EDGE + 50 + across * (k % columns)
        top = HEAD + 30 + down * (k // columns)
        write_text(figure, left, top - 26, title, bold=True, size=SMALL)
        own = place_axes(figure, left, top, PANEL, PANEL)
        own.tick_params(labelsize=SMALL * 0.8, colors=FAINT)
        own.spines[:].set_color(FAINT)
        axes.append(own)
    return figure, axes


def draw_photograph(axes: "Axes", picture: Greys) -> None:
    """Show a picture, small, in axes over its pixels."""
    small = reduced(picture, PICTURE)
    height, width = picture.shape
    axes.imshow(small, cmap="gray", vmin=0, vmax=1, extent=(-0.5, width - 0.5, height - 0.5, -0.5))


def draw_points(figure: "Figure", axes: "Axes", at: Floats, values: Floats, unit: str) -> None:
    """Colour points by a value, with a colour bar."""
    scale: ColourScale = colour_scale(values)
    axes.scatter(
        at[:, 0],
        at[:, 1],
        c=values,
        s=max(0.8, min(14.0, 2.6e4 / max(1, len(at)))),
        cmap=scale.map,
        vmin=scale.low,
        vmax=scale.high,
        linewidths=0,
        rasterized=True,
    )
    axes.set_aspect("equal")
    box = axes.get_position()
    across, down = figure.get_size_inches() * figure.dpi
    left, top = box.x1 * across + 14, (1 - box.y1) * down
    draw_colour_bar(figure, (left, top, BAR * 0.7, box.height * down), scale, unit)
