"""Grey noise from two pictures of one state, which may have moved a little."""

import numpy as np

from shapemorph.core.arrays import Floats, Greys
from shapemorph.core.image import GreyImage

TILE = 24  # px
LEAST_TILES = 4
FARTHEST = 0.5  # px: beyond it a picture is not its own tangent any more
TERMS = 8  # of the fit in a tile: shift 2, its slopes 4, gain, offset


def pair_noise(first: GreyImage, second: GreyImage) -> float:
    """Estimate the standard deviation of the noise of a pixel from a repeated picture.

    In each small tile the difference of the two pictures is explained by a little motion
    (a shift and its slopes, times the gradients of grey), a gain and an offset; what is
    left is noise of both.

    Parameters
    ----------
    first, second : GreyImage
        Of one size; grey in [0, 1].

    Returns
    -------
    float
        Grey in [0, 1], of one picture; the median over tiles. NaN where the pictures have
        moved by more than half a pixel, or show too little.
    """
    if first.shape != second.shape:
        return float("nan")
    both = (first.mask & second.mask).astype(np.float64)
    middle = 0.5 * (first.grey.astype(np.float64) + second.grey)
    difference = second.grey.astype(np.float64) - first.grey
    slopes = [np.asarray(np.gradient(middle, axis=axis)) for axis in (0, 1)]
    noise, shift = [], []
    for rows, cols in _tiles(first.shape):
        if both[rows, cols].min() < 1.0:
            continue
        along_y, along_x = (slope[rows, cols] for slope in slopes)
        left, moved = _explain(difference[rows, cols], along_x, along_y, middle[rows, cols])
        noise.append(left)
        shift.append(moved)
    if len(noise) < LEAST_TILES or np.median(shift) > FARTHEST:
        return float("nan")
    return float(np.median(noise) / np.sqrt(2.0))


def _tiles(shape: tuple[int, int]) -> list[tuple[slice, slice]]:
    """Tiles side by side, a pixel from the rim, where differences are one-sided."""
    return [
        (slice(row, row + TILE), slice(col, col + TILE))
        for row in range(1, shape[0] - TILE, TILE)
        for col in range(1, shape[1] - TILE, TILE)
    ]


def _explain(
    difference: Floats, along_x: Floats, along_y: Floats, grey: Floats | Greys
) -> tuple[float, float]:
    """Fit the tile: standard deviation of what is left, and length of the shift, px."""
    y, x = np.mgrid[: difference.shape[0], : difference.shape[1]] / TILE - 0.5
    terms = [along_x, along_y, along_x * x, along_x * y, along_y * x, along_y * y]
    matrix = np.stack([*terms, grey, np.ones_like(grey)], axis=-1).reshape(-1, TERMS)
    found, *_ = np.linalg.lstsq(matrix, difference.ravel(), rcond=None)
    left = difference.ravel() - matrix @ found
    freedom = max(len(left) - TERMS, 1)
    return float(np.sqrt((left**2).sum() / freedom)), float(np.hypot(found[0], found[1]))
