"""Normal equations of a penalised cubic B-spline surface, and their banded Cholesky factor.

A symmetric matrix of half-bandwidth b is kept by its lower rows: ``band[i, b - (i - j)]``
is the entry (i, j), j <= i. Coefficient (row, col) of a grid of `width` columns is
unknown number ``row * width + col``, so that b = 3 * width + 3.
"""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Floats, Ints
from shapemorph.kernels.bspline import cubic_weights

_SUM_IN_ANY_ORDER = {"reassoc", "contract", "nsz"}  # unlike fastmath=True this keeps NaN


@njit(cache=True)
def basis(points: Floats, height: int, width: int) -> tuple[Ints, Floats]:
    """Find the 16 coefficients that act at each point, and their weights.

    Parameters
    ----------
    points : (N, 2)
        Positions (x, y) in units of the grid, between 1 and width - 2 (height - 2).

    Returns
    -------
    first : (N,)
        Number of the lowest unknown that acts; the others follow by rows of four.
    weights : (N, 16)
    """
    first = np.empty(points.shape[0], np.int64)
    weights = np.empty((points.shape[0], 16))
    for k in range(points.shape[0]):
        col = min(max(int(points[k, 0]), 1), width - 3)
        row = min(max(int(points[k, 1]), 1), height - 3)
        wx, wy = cubic_weights(points[k, 0] - col), cubic_weights(points[k, 1] - row)
        first[k] = (row - 1) * width + col - 1
        for j in range(4):
            for i in range(4):
                weights[k, 4 * j + i] = wy[j] * wx[i]
    return first, weights


@njit(cache=True)
def data_equations(
    first: Ints, weights: Floats, importance: Floats, values: Floats, height: int, width: int
) -> tuple[Floats, Floats]:
    """Sum the normal equations of weighted least squares over all points.

    Returns
    -------
    band : (height * width, 3 * width + 4)
        Lower band of B^T W B.
    right : (height * width, D)
        B^T W values.
    """
    half = 3 * width + 3
    band = np.zeros((height * width, half + 1))
    right = np.zeros((height * width, values.shape[1]))
    for k in range(first.shape[0]):
        for a in range(16):
            i = first[k] + (a // 4) * width + a % 4
            weighted = importance[k] * weights[k, a]
            for d in range(values.shape[1]):
                right[i, d] += weighted * values[k, d]
            for b in range(a + 1):
                j = first[k] + (b // 4) * width + b % 4
                band[i, half - (i - j)] += weighted * weights[k, b]
    return band, right


@njit(cache=True)
def bending_equations(height: int, width: int) -> Floats:
    """Sum of squared second differences of the coefficients, as a lower band.

    Returns
    -------
    (height * width, 3 * width + 4)
        Matrix P with c^T P c = sum of c_xx^2 + 2 c_xy^2 + c_yy^2; linear fields cost nothing.
    """
    half = 3 * width + 3
    band = np.zeros((height * width, half + 1))
    second, twist = np.array([1.0, -2.0, 1.0]), np.array([1.0, -1.0, -1.0, 1.0])
    for row in range(height):
        for col in range(width):
            n = row * width + col
            if col < width - 2:
                _add_square(band, np.array([n, n + 1, n + 2]), second, 1.0)
            if row < height - 2:
                _add_square(band, np.array([n, n + width, n + 2 * width]), second, 1.0)
            if col < width - 1 and row < height - 1:
                _add_square(band, np.array([n, n + 1, n + width, n + width + 1]), twist, 2.0)
    return band


@njit(cache=True)
def _add_square(band: Floats, index: Ints, stencil: Floats, factor: float) -> None:
    half = band.shape[1] - 1
    for a in range(index.size):
        for b in range(a + 1):
            band[index[a], half - (index[a] - index[b])] += factor * stencil[a] * stencil[b]


@njit(cache=True, fastmath=_SUM_IN_ANY_ORDER)
def _dot(left: Floats, right: Floats) -> float:
    total = 0.0
    for k in range(left.size):
        total += left[k] * right[k]
    return total


@njit(cache=True)
def factorise(band: Floats) -> Floats:
    """Cholesky factor of a positive definite band, in the same storage.

    Returns
    -------
    (N, b + 1)
        Lower factor; NaN from the first row on where the matrix is not positive definite.
    """
    size, half = band.shape[0], band.shape[1] - 1
    factor = np.zeros_like(band)
    for i in range(size):
        start = max(0, i - half)
        for j in range(start, i + 1):
            before = factor[i, half - i + start : half - i + j]
            total = band[i, half - (i - j)] - _dot(before, factor[j, half - j + start : half])
            if j < i:
                factor[i, half - (i - j)] = total / factor[j, half]
            else:
                factor[i, half] = np.sqrt(total) if total > 0.0 else np.nan
    return factor


@njit(cache=True)
def solve(factor: Floats, right: Floats) -> Floats:
    """Solve with a factor of :func:`factorise`.

    Parameters
    ----------
    factor : (N, b + 1)
    right : (N, D)

    Returns
    -------
    (N, D)
    """
    size, half = factor.shape[0], factor.shape[1] - 1
    solution = right.copy()
    for d in range(right.shape[1]):
        for i in range(size):
            total = solution[i, d]
            for k in range(max(0, i - half), i):
                total -= factor[i, half - (i - k)] * solution[k, d]
            solution[i, d] = total / factor[i, half]
        for i in range(size - 1, -1, -1):
            value = solution[i, d] / factor[i, half]
            solution[i, d] = value
            for k in range(max(0, i - half), i):
                solution[k, d] -= factor[i, half - (i - k)] * value
    return solution


@njit(cache=True, nogil=True, parallel=True)
def leverages(factor: Floats, first: Ints, weights: Floats, width: int) -> Floats:
    """How much each point would pull the surface at its own place: b^T A^-1 b.

    Parameters
    ----------
    factor : (N, b + 1)
        Factor of A.
    first, weights
        As :func:`basis` gives them, for the points asked about.

    Returns
    -------
    (K,)
        Leverage of a point of importance one.
    """
    result = np.empty(first.shape[0])
    for p in prange(first.shape[0]):
        result[p] = _leverage(factor, first[p], weights[p], width)
    return result


@njit(cache=True)
def _leverage(factor: Floats, first: int, weights: Floats, width: int) -> float:
    size, half = factor.shape[0], factor.shape[1] - 1
    column = np.zeros(size)
    for a in range(16):
        column[first + (a // 4) * width + a % 4] = weights[a]
    square = 0.0
    for i in range(first, size):
        start = max(first, i - half)
        known = _dot(factor[i, half - i + start : half], column[start:i])
        column[i] = (column[i] - known) / factor[i, half]
        square += column[i] * column[i]
    return square
