"""Picture of two pictures that could not be matched, with what looked alike in them."""

from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.image import GreyImage
from shapemorph.view.layout import EDGE, HEAD, Heading, write_heading
from shapemorph.view.style import FAINT, INK, new_figure, place_axes, reduced

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL, BETWEEN = 600, 60
"""Largest side of a picture and room between two, px."""


def failed_match_figure(
    reference: GreyImage, deformed: GreyImage, reference_px: Floats, deformed_px: Floats
) -> "Figure":
    """Put both pictures side by side and join features that look alike, right or wrong.

    Parameters
    ----------
    reference, deformed : GreyImage
    reference_px, deformed_px : (N, 2)
        The pairs that an `UnmatchedError` carries, px.
    """
    scales = [PANEL / max(image.shape) for image in (reference, deformed)]
    (tall_0, wide_0), (tall_1, wide_1) = (
        [scale * length for length in image.shape]
        for scale, image in zip(scales, (reference, deformed), strict=True)
    )
    offset = wide_0 + BETWEEN
    across, tall = offset + wide_1, max(tall_0, tall_1)
    figure = new_figure(max(960, 2 * EDGE + across), HEAD + tall + EDGE)
    note = f"{len(reference_px)} features look alike; too few of them agree with each other"
    write_heading(figure, Heading("Not matched: reference (left) and deformed (right)", note))
    axes = place_axes(figure, EDGE, HEAD, across, tall)
    axes.set_axis_off()
    _draw_grey(axes, reference, (0, wide_0, tall_0, 0))
    _draw_grey(axes, deformed, (offset, offset + wide_1, tall_1, 0))
    axes.set(xlim=(0, across), ylim=(tall, 0))
    start = (reference_px + 0.5) * scales[0]
    end = (deformed_px + 0.5) * scales[1] + [offset, 0]
    for points in (start, end):
        axes.plot(points[:, 0], points[:, 1], ".", color=INK, markersize=3)
    axes.plot(*np.stack([start, end], axis=1).transpose(2, 1, 0), color=FAINT, linewidth=0.5)
    return figure


def _draw_grey(axes: "Axes", image: GreyImage, extent: tuple[float, float, float, float]) -> None:
    """Show a picture as it is, white outside its mask."""
    grey = np.where(image.mask, image.grey, 1.0).astype(np.float32)
    axes.imshow(reduced(grey, PANEL), cmap="gray", vmin=0, vmax=1, extent=extent, aspect="auto")
