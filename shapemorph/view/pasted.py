"""Pictures that stand in a figure pixel for pixel."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.artist import Artist

from shapemorph.view.style import DPI
from shapemorph.view.window import Pixels


class Pasted(Artist):
    """Pixels as they are; figimage would carry them through a map and a resampling.

    Parameters
    ----------
    left, top : int
        px of the layout from the upper left corner of the figure.
    pixels_at : callable
        Makes the picture (H, W, 3), whose pixels become those of the file; called with
        their number for one px of the layout when the figure is drawn.
    """

    def __init__(self, left: int, top: int, pixels_at: Callable[[int], Pixels]) -> None:
        super().__init__()
        self._corner, self._pixels_at = (left, top), pixels_at

    def draw(self, renderer: Any) -> None:
        """Put them on the canvas."""
        ratio = round(renderer.dpi / DPI)
        pixels = self._pixels_at(ratio)
        left, top = self._corner
        low = renderer.height - ratio * top - pixels.shape[0]
        opaque = np.empty((*pixels.shape[:2], 4), dtype=np.uint8)
        opaque[..., :3], opaque[..., 3] = pixels[::-1], 255
        renderer.draw_image(renderer.new_gc(), ratio * left, low, opaque)
