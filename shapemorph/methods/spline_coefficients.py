"""Coefficients of the B-spline through the pixels of a picture."""

from functools import partial

import numpy as np

from shapemorph.core.arrays import Floats, Greys
from shapemorph.kernels.pyramid import filter_lines
from shapemorph.methods.threads import run_blocks

CUBIC, QUINTIC = 3, 5
POLES: dict[int, Floats] = {  # of the recursive filter, by the degree of the spline
    CUBIC: np.array([np.sqrt(3.0) - 2.0]),
    QUINTIC: np.array(
        [
            np.sqrt(135.0 / 2.0 - np.sqrt(17745.0 / 4.0)) + np.sqrt(105.0 / 4.0) - 13.0 / 2.0,
            np.sqrt(135.0 / 2.0 + np.sqrt(17745.0 / 4.0)) - np.sqrt(105.0 / 4.0) - 13.0 / 2.0,
        ]
    ),
}
BLOCK = 64  # lines that a thread takes at once


def to_coefficients(picture: Greys, repeats: int, *, degree: int = CUBIC) -> None:
    """Turn a contiguous picture (H, W) into its B-spline coefficients, in place.

    Beyond its border the picture goes on mirrored, or again from the other side where
    `repeats` is 1. The degree of the spline is 3 or 5.

    References
    ----------
    M. Unser, A. Aldroubi, M. Eden, "B-spline signal processing: part II", IEEE Transactions
    on Signal Processing 41 (1993), doi:10.1109/78.193221.
    """
    height, width = picture.shape
    texels = picture.ravel()
    for down, length, lines in ((1, height, width), (0, width, height)):
        work = partial(filter_lines, texels, height, width, POLES[degree], down, repeats)
        if length > 1:
            run_blocks(work, lines, block=BLOCK)
