"""B-spline sampling of images and of coefficient grids."""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Floats


@njit(cache=True, inline="always")
def cubic_weights(t: float) -> tuple[float, float, float, float]:
    """Weights of the four knots around offset t in [0, 1)."""
    s = 1.0 - t
    left = 2.0 / 3.0 - 0.5 * t * t * (2.0 - t)
    right = 2.0 / 3.0 - 0.5 * s * s * (2.0 - s)
    return s * s * s / 6.0, left, right, t * t * t / 6.0


@njit(cache=True, inline="always")
def cubic_slopes(t: float) -> tuple[float, float, float, float]:
    """Differentiate :func:`cubic_weights` with respect to t."""
    s = 1.0 - t
    return -0.5 * s * s, t * (1.5 * t - 2.0), s * (2.0 - 1.5 * s), 0.5 * t * t


@njit(cache=True, inline="always")
def quintic_weights(t: float) -> tuple[float, float, float, float, float, float]:
    """Weights of the six knots of a quintic spline around offset t in [0, 1)."""
    s = 1.0 - t
    tt, ss = t * t, s * s
    t5, s5 = tt * tt * t, ss * ss * s
    return (
        s5 / 120.0,
        (1.0 + s * (5.0 + s * (10.0 + s * (10.0 + 5.0 * s))) - 5.0 * s5) / 120.0,
        (26.0 + s * (50.0 + s * (20.0 - s * (20.0 + 20.0 * s))) + 10.0 * s5) / 120.0,
        (26.0 + t * (50.0 + t * (20.0 - t * (20.0 + 20.0 * t))) + 10.0 * t5) / 120.0,
        (1.0 + t * (5.0 + t * (10.0 + t * (10.0 + 5.0 * t))) - 5.0 * t5) / 120.0,
        t5 / 120.0,
    )


@njit(cache=True, nogil=True, parallel=True)
def sample(coefficients: Floats, points: Floats) -> Floats:
    """Evaluate a spline at scattered points.

    Parameters
    ----------
    coefficients : (H, W)
        ``scipy.ndimage.spline_filter(image, order=3)`` of an image, or a control grid.
    points : (N, 2)
        Positions (x, y), x along columns, coefficient centres at integers.

    Returns
    -------
    (N,)
        Values; NaN where the 4 x 4 support leaves the array.
    """
    height, width = coefficients.shape
    values = np.full(points.shape[0], np.nan)
    for k in prange(points.shape[0]):
        x, y = points[k, 0], points[k, 1]
        if not (1.0 <= x < width - 2.0 and 1.0 <= y < height - 2.0):
            continue
        col, row = int(x), int(y)
        wx, wy = cubic_weights(x - col), cubic_weights(y - row)
        total = 0.0
        for j in range(4):
            for i in range(4):
                total += wy[j] * wx[i] * coefficients[row - 1 + j, col - 1 + i]
        values[k] = total
    return values


@njit(cache=True, nogil=True)
def fill_vectors(coefficients: Floats, points: Floats, values: Floats, gradients: Floats) -> None:
    """Evaluate a vector-valued spline and its derivatives at scattered points.

    Parameters
    ----------
    coefficients : (H, W, D)
        Control grid.
    points : (N, 2)
        Positions (x, y) in units of the grid.
    values : (N, D)
        Filled; NaN where the 4 x 4 support leaves the grid.
    gradients : (N, D, 2)
        Filled with the derivatives with respect to x and y in units of the grid; NaN likewise.
    """
    height, width, depth = coefficients.shape
    for k in range(points.shape[0]):
        x, y = points[k, 0], points[k, 1]
        if not (1.0 <= x <= width - 2.0 and 1.0 <= y <= height - 2.0):
            for d in range(depth):
                values[k, d], gradients[k, d, 0], gradients[k, d, 1] = np.nan, np.nan, np.nan
            continue
        col, row = min(int(x), width - 3), min(int(y), height - 3)
        wx, wy = cubic_weights(x - col), cubic_weights(y - row)
        sx, sy = cubic_slopes(x - col), cubic_slopes(y - row)
        for d in range(depth):
            value, along_x, along_y = 0.0, 0.0, 0.0
            for j in range(4):
                for i in range(4):
                    c = coefficients[row - 1 + j, col - 1 + i, d]
                    value += wy[j] * wx[i] * c
                    along_x += wy[j] * sx[i] * c
                    along_y += sy[j] * wx[i] * c
            values[k, d] = value
            gradients[k, d, 0] = along_x
            gradients[k, d, 1] = along_y
