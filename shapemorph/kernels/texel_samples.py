"""How a pixel is sampled in a texture: at which reduction, how turned, how often.

A texture is a table of B-spline coefficients at several reductions by boxes of 2 x 2 texels.
"""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Greys
from shapemorph.kernels.bspline import cubic_weights
from shapemorph.kernels.pyramid import index_inside

SAMPLES = 4.0  # texels along a pixel, at most; beyond it a reduced level is read ...
SHARPEST = 2.0  # ... unless fewer than half as many were left across a narrow one
MOST_SAMPLES = 32
NARROW = 1.15  # sides of a pixel, in texels, that differ more are sampled along and across
SHARP = 0.01  # variance, texels^2 / 12, that is not worth a second sample


@njit(cache=True)
def interpolate(
    texels: Greys, offset: int, height: int, width: int, repeats: int, x: float, y: float
) -> float:
    """Grey at a place of one reduction, in its own texels."""
    if not repeats:
        x, y = min(max(x, 0.0), width - 1.0), min(max(y, 0.0), height - 1.0)
    col, row = int(np.floor(x)), int(np.floor(y))
    wx, wy = cubic_weights(x - col), cubic_weights(y - row)
    total = 0.0
    if 1 <= col < width - 2 and 1 <= row < height - 2:
        for j in range(4):
            start = offset + (row - 1 + j) * width + col - 1
            line = 0.0
            for i in range(4):
                line += wx[i] * texels[start + i]
            total += wy[j] * line
        return total
    for j in range(4):
        start = offset + index_inside(row - 1 + j, height, repeats) * width
        line = 0.0
        for i in range(4):
            line += wx[i] * texels[start + index_inside(col - 1 + i, width, repeats)]
        total += wy[j] * line
    return total


@njit(cache=True, inline="always")
def choose_level(along_x: float, along_y: float, base: int, levels: int) -> int:
    """Level at which a pixel of this many texels needs few samples and stays sharp."""
    few = np.sqrt(along_x * along_y) / SAMPLES
    sharp = min(along_x, along_y) / SHARPEST
    excess = max(min(few, sharp), max(along_x, along_y) / MOST_SAMPLES)
    level = int(np.ceil(np.log2(excess) - 1e-3)) if excess > 1.0 else 0
    return min(max(level, base), base + levels - 1)


@njit(cache=True, inline="always")
def principal_turn(ux: float, uy: float, vx: float, vy: float) -> tuple[float, float]:
    """Cosine and sine of the turn of a pixel that lays its sides along and across.

    A pixel that shows a long narrow piece of the texture keeps its width and sharpness
    only if it is sampled along that piece; a turned square has the same variance. One
    that shows about a square is left as it is.

    Parameters
    ----------
    ux, uy, vx, vy : float
        Texels along u and v of a step of one pixel along x, along y.
    """
    xx, yy, xy = ux * ux + vx * vx, uy * uy + vy * vy, ux * uy + vx * vy
    half, mean = np.hypot(0.5 * (xx - yy), xy), 0.5 * (xx + yy)
    if mean + half <= NARROW * NARROW * (mean - half):
        return 1.0, 0.0
    angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
    return np.cos(angle), np.sin(angle)


@njit(cache=True, inline="always")
def spread_samples(texels: float) -> tuple[int, float]:
    """Choose number and distance (as a share of the pixel) of samples along a pixel.

    A texel is a mean over its own width already: a pixel of `texels` > 1 texels is left
    with the variance of a box sqrt(texels^2 - 1) wide. The samples have just that
    variance, so that sharpness does not jump with their number.
    """
    missing = texels * texels - 1.0
    if missing < SHARP:
        return 1, 0.0
    count = min(max(int(np.ceil(np.sqrt(missing))), 2), MOST_SAMPLES)
    return count, np.sqrt(missing / (count * count - 1.0)) / texels
