"""Coefficients of the cubic B-spline through the pixels of a picture."""

from functools import partial

from shapemorph.core.arrays import Greys
from shapemorph.kernels.pyramid import filter_lines
from shapemorph.methods.threads import run_blocks

BLOCK = 64  # lines that a thread takes at once


def to_coefficients(picture: Greys, repeats: int) -> None:
    """Turn a contiguous picture (H, W) into its cubic B-spline coefficients, in place.

    Beyond its border the picture goes on mirrored, or again from the other side where
    `repeats` is 1.
    """
    height, width = picture.shape
    texels = picture.ravel()
    for down, length, lines in ((1, height, width), (0, width, height)):
        work = partial(filter_lines, texels, height, width, down, repeats)
        if length > 1:
            run_blocks(work, lines, block=BLOCK)
