"""Random error of matched subsets from the residual of the match.

What is left of the grey after a match is the noise of both pictures as the match saw
it, resampling included. Its autocovariance at short lags, together with the weight
that each pixel has in the solution, gives the variance of the solution.
"""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.kernels.bspline import quintic_weights
from shapemorph.kernels.inner import inner
from shapemorph.kernels.small_linear import clear, factor, solve
from shapemorph.kernels.subset_hessian import fill_hessian, mean_grey, reference_moments
from shapemorph.kernels.subset_rows import VECTOR_FLAGS
from shapemorph.kernels.vectors import LANES

_ZERO = np.float32(0.0)
_ONE = np.float32(1.0)


@inner(forceinline=True)
def _place(warp, a, b):  # type: ignore[no-untyped-def]
    """Warped position of the local pixel (a, b) relative to the centre."""
    x = warp[0] + warp[1] * a + warp[2] * b + warp[3] * a * a + warp[4] * a * b + warp[5] * b * b
    y = warp[6] + warp[7] * a + warp[8] * b + warp[9] * a * a + warp[10] * a * b + warp[11] * b * b
    return x, y


@inner(forceinline=True, fastmath=VECTOR_FLAGS)
def _cubic(c, x, y):  # type: ignore[no-untyped-def]
    """Value of the cubic spline at one position."""
    col, row = int(np.floor(x)), int(np.floor(y))
    t, u = x - col, y - row
    total = 0.0
    for j in range(4):
        v = abs(u + 1.0 - j)
        wy = (4.0 - 6.0 * v * v + 3.0 * v * v * v) if v < 1.0 else (2.0 - v) * (2.0 - v) * (2.0 - v)
        for i in range(4):
            h = abs(t + 1.0 - i)
            wx = (
                (4.0 - 6.0 * h * h + 3.0 * h * h * h)
                if h < 1.0
                else (2.0 - h) * (2.0 - h) * (2.0 - h)
            )
            total += wy * wx * c[row - 1 + j, col - 1 + i]
    return total / 36.0


@inner(forceinline=True)
def _quintic(c, x, y):  # type: ignore[no-untyped-def]
    """Value of the quintic spline at one position."""
    col, row = int(np.floor(x)), int(np.floor(y))
    wx, wy = quintic_weights(x - col), quintic_weights(y - row)
    total = 0.0
    for j in range(6):
        for i in range(6):
            total += wy[j] * wx[i] * c[row - 2 + j, col - 2 + i]
    return total


@inner()
def load_weights(inside, other_inside, x, y, warp, radius, weights) -> float:  # type: ignore[no-untyped-def]
    """Mark the pixels of a subset that count in both pictures; return their number."""
    height, length = inside.shape
    total = 0.0
    for j in range(2 * radius + 1):
        for i in range(2 * radius + 1):
            weights[j, i] = _ZERO
            if inside[y + j - radius, x + i - radius] == _ZERO:
                continue
            at_x, at_y = _place(warp, float(i - radius), float(j - radius))
            at_x, at_y = x + at_x, y + at_y
            if not (2.0 <= at_x < length - 4.0 and 2.0 <= at_y < height - 4.0):
                continue
            if other_inside[int(np.floor(at_y + 0.5)), int(np.floor(at_x + 0.5))] != _ZERO:
                weights[j, i] = _ONE
                total += 1.0
    return total


@inner()
def load_grey(coefficients, wide, x, y, warp, radius, weights, found) -> None:  # type: ignore[no-untyped-def]
    """Sample the deformed picture at the pixels that count."""
    for j in range(2 * radius + 1):
        for i in range(2 * radius + 1):
            found[j, i] = _ZERO
            if weights[j, i] != _ZERO:
                at_x, at_y = _place(warp, float(i - radius), float(j - radius))
                at_x, at_y = x + at_x, y + at_y
                if wide is None:
                    found[j, i] = np.float32(_cubic(coefficients, at_x, at_y))
                else:
                    found[j, i] = np.float32(_quintic(coefficients, at_x, at_y))


@inner()
def take_residual(reference, x, y, radius, weights, found, system) -> None:  # type: ignore[no-untyped-def]
    """Replace the deformed grey by what gain, offset and a plane do not explain."""
    matrix, lower, right, solution = system[0:4], system[4:8], system[8], system[9]
    for a in range(4):
        clear(matrix[a])
    clear(right)
    terms = np.empty(4)
    for j in range(2 * radius + 1):
        for i in range(2 * radius + 1):
            if weights[j, i] == _ZERO:
                continue
            terms[0], terms[1], terms[2] = 1.0, (i - radius) / radius, (j - radius) / radius
            terms[3] = found[j, i] - 0.5
            grey = reference[0, y + j - radius, x + i - radius]
            for a in range(4):
                right[a] += terms[a] * grey
                for b in range(a + 1):
                    matrix[a, b] += terms[a] * terms[b]
    if factor(matrix, 4, 0.0, lower):
        solve(lower, right, 4, solution)
        gain = _ONE
    else:
        clear(solution)
        gain = _ZERO
    for j in range(2 * radius + 1):
        for i in range(2 * radius + 1):
            if weights[j, i] == _ZERO:
                continue
            grey = gain * reference[0, y + j - radius, x + i - radius]
            explained = solution[0] + solution[3] * (found[j, i] - 0.5)
            explained += (solution[1] * (i - radius) + solution[2] * (j - radius)) / radius
            found[j, i] = np.float32(grey - explained)


@inner(fastmath=VECTOR_FLAGS)
def _lag_product(a, b, offset, length) -> float:  # type: ignore[no-untyped-def]
    """Sum of a[i] b[i + offset] over flat arrays whose rows end in zeros."""
    total = _ZERO
    shift = np.uint64(offset)
    for i in range(np.uint64(length)):
        total += a[i] * b[shift + i]
    return float(total)


@inner()
def _largest(lags) -> int:  # type: ignore[no-untyped-def]
    largest = 0
    for n in range(lags.shape[0]):
        largest = max(largest, abs(lags[n, 0]), abs(lags[n, 1]))
    return largest


@njit(cache=True, nogil=True, error_model="numpy")
def residual_products(
    reference: Greys,
    coefficients: Greys,
    wide: int | None,
    inside: Greys,
    other_inside: Greys,
    points: Ints,
    warps: Floats,
    radius: int,
    lags: Ints,
    products: Floats,
    pairs: Floats,
) -> None:
    """Sum the products of the residual with itself at short lags, subset by subset.

    Parameters
    ----------
    reference, coefficients, wide, points, warps, radius
        As in :func:`~shapemorph.kernels.icgn.match_subsets`; the warps are its results.
    inside, other_inside : (H, W) float32
        1 where a pixel of the reference, of the deformed picture counts.
    lags : (K, 2) int64
        Rows down (>= 0) and columns to the right.
    products, pairs : (N, K)
        Filled with the sums, and with the number of pairs of pixels in them.
    """
    width = 2 * radius + 1
    room = _largest(lags)
    pitch = width + room
    length = width * pitch
    weights = np.zeros((pitch + 1, pitch), dtype=np.float32)
    found = np.zeros((pitch + 1, pitch), dtype=np.float32)
    flat_weights, flat_found = weights.reshape(-1), found.reshape(-1)
    system = np.zeros((10, 4))
    for k in range(points.shape[0]):
        x, y = points[k, 0], points[k, 1]
        load_weights(inside, other_inside, x, y, warps[k], radius, weights)
        load_grey(coefficients, wide, x, y, warps[k], radius, weights, found)
        take_residual(reference, x, y, radius, weights, found, system)
        for n in range(lags.shape[0]):
            offset = lags[n, 0] * pitch + lags[n, 1]
            products[k, n] = _lag_product(flat_found, flat_found, offset, length)
            pairs[k, n] = _lag_product(flat_weights, flat_weights, offset, length)


@inner()
def _fill_influence(  # type: ignore[no-untyped-def]
    reference, x, y, radius, terms, weights, mean, count, energy, total, along, rows, influence
):  # fmt: skip
    """Weight of each pixel's grey in u and v of the solution."""
    for axis in range(2):
        sum_total, sum_along = 0.0, 0.0
        for a in range(2 * terms):
            at = 3 + a if a < terms else 9 + a - terms
            sum_total += rows[axis, a] * total[at]
            sum_along += rows[axis, a] * along[at]
        for j in range(2 * radius + 1):
            local_y = float(j - radius)
            for i in range(2 * radius + 1):
                influence[axis, j, i] = _ZERO
                if weights[j, i] == _ZERO:
                    continue
                local_x = float(i - radius)
                row, col = y + j - radius, x + i - radius
                px, py = rows[axis, 0], rows[axis, terms]
                if terms >= 3:
                    px += rows[axis, 1] * local_x + rows[axis, 2] * local_y
                    py += rows[axis, terms + 1] * local_x + rows[axis, terms + 2] * local_y
                if terms == 6:
                    px += (
                        rows[axis, 3] * local_x * local_x
                        + rows[axis, 4] * local_x * local_y
                        + rows[axis, 5] * local_y * local_y
                    )
                    py += (
                        rows[axis, 9] * local_x * local_x
                        + rows[axis, 10] * local_x * local_y
                        + rows[axis, 11] * local_y * local_y
                    )
                value = px * reference[1, row, col] + py * reference[2, row, col]
                value -= sum_total / count
                value -= sum_along / energy * (reference[0, row, col] - mean)
                influence[axis, j, i] = np.float32(value)


@njit(cache=True, nogil=True, error_model="numpy")
def solution_covariance(
    reference: Greys,
    inside: Greys,
    other_inside: Greys,
    points: Ints,
    warps: Floats,
    radius: int,
    order: int,
    second: int | None,
    lags: Ints,
    covariance: Floats,
    least_share: float,
    result: Floats,
) -> None:
    """Covariance of the matched position from the autocovariance of the grey noise.

    Parameters
    ----------
    reference, inside, other_inside, points, warps, radius, lags
        As in :func:`residual_products`; the first lag is zero.
    order, second
        As in :func:`~shapemorph.kernels.icgn.match_subsets`.
    covariance : (N, K)
        Of the noise in the residual, at each lag; a lag stands for its opposite too.
    least_share : float
        A variance is at least this share of what white noise of the same strength causes.
    result : (N, 3)
        Filled with the variance of x, of y and their covariance, px^2; NaN
        where there is no pattern.
    """
    width = 2 * radius + 1
    terms = (order + 1) * (order + 2) // 2
    room = _largest(lags)
    pitch = (width + room + LANES - 1) // LANES * LANES
    length = width * pitch
    weights = np.zeros((width, pitch), dtype=np.float32)
    influence = np.zeros((2, pitch + 1, pitch), dtype=np.float32)
    in_x, in_y = influence[0].reshape(-1), influence[1].reshape(-1)
    lane_x = np.empty(pitch, dtype=np.float32)
    for i in range(pitch):
        lane_x[i] = np.float32(i - radius)
    system = np.zeros((32, 15))
    hessian, lower, products = system[0:12], system[12:24], system[24:27]
    total, along, unit, rows = system[27], system[28], system[29], system[30:32]
    for k in range(points.shape[0]):
        for a in range(3):
            result[k, a] = np.nan
        x, y = points[k, 0], points[k, 1]
        count = load_weights(inside, other_inside, x, y, warps[k], radius, weights)
        if count < 4:
            continue
        mean = mean_grey(reference, weights, y - radius, x - radius, count)
        reference_moments(
            reference, weights, lane_x, y - radius, x - radius, mean, second, products, total,
            along,
        )  # fmt: skip
        offset = along[0] / count
        energy = along[1] - along[0] * offset
        if not energy > 0.0:
            continue
        for a in range(3, 15):
            along[a] -= offset * total[a]
        fill_hessian(products, total, along, count, energy, terms, hessian)
        if not factor(hessian, 2 * terms, 0.0, lower):
            continue
        for axis in range(2):
            clear(unit)
            unit[axis * terms] = 1.0
            solve(lower, unit, 2 * terms, rows[axis])
        _fill_influence(
            reference, x, y, radius, terms, weights, float(mean) + offset, count, energy,
            total, along, rows, influence,
        )  # fmt: skip
        xx = covariance[k, 0] * _lag_product(in_x, in_x, 0, length)
        yy = covariance[k, 0] * _lag_product(in_y, in_y, 0, length)
        xy = covariance[k, 0] * _lag_product(in_x, in_y, 0, length)
        least_xx, least_yy = least_share * xx, least_share * yy
        for n in range(1, lags.shape[0]):
            at = lags[n, 0] * pitch + lags[n, 1]
            xx += 2.0 * covariance[k, n] * _lag_product(in_x, in_x, at, length)
            yy += 2.0 * covariance[k, n] * _lag_product(in_y, in_y, at, length)
            shared = _lag_product(in_x, in_y, at, length) + _lag_product(in_y, in_x, at, length)
            xy += covariance[k, n] * shared
        result[k, 0], result[k, 1] = max(xx, least_xx), max(yy, least_yy)
        limit = np.sqrt(result[k, 0] * result[k, 1])
        result[k, 2] = min(max(xy, -limit), limit)
