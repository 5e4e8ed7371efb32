"""Random error of matched subsets from the residual of the match.

What is left of the grey after a match is the noise of both pictures as the match saw
it, resampling included. Its autocovariance at short lags, together with the weight
that each pixel has in the solution, gives the variance of the solution.
"""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.kernels.inner import inner
from shapemorph.kernels.small_linear import clear, factor, solve
from shapemorph.kernels.subset_hessian import fill_hessian, mean_grey, reference_moments
from shapemorph.kernels.subset_light import fit_light, residual
from shapemorph.kernels.subset_rows import VECTOR_FLAGS
from shapemorph.kernels.vectors import LANES, fused, load, spread, store, total


@inner(fastmath=VECTOR_FLAGS)
def _lag_product(a, b, offset, length) -> float:  # type: ignore[no-untyped-def]
    """Sum of a[i] b[i + offset] over flat arrays whose rows end in zeros."""
    sum_ = np.float32(0.0)
    shift = np.uint64(offset)
    for i in range(np.uint64(length)):
        sum_ += a[i] * b[shift + i]
    return float(sum_)


@inner()
def _largest(lags) -> int:  # type: ignore[no-untyped-def]
    largest = 0
    for n in range(lags.shape[0]):
        largest = max(largest, abs(lags[n, 0]), abs(lags[n, 1]))
    return largest


@njit(cache=True, nogil=True, error_model="numpy")
def residual_products(
    reference: Greys,
    points: Ints,
    weights: Greys,
    grey: Greys,
    lags: Ints,
    products: Floats,
    pairs: Floats,
) -> None:
    """Sum the products of the residual with itself at short lags, subset by subset.

    Parameters
    ----------
    reference, points
        As in :func:`~shapemorph.kernels.icgn.match_subsets`.
    weights, grey : (N, R, L) float32
        See :func:`~shapemorph.kernels.subset_samples.sample_subsets`; L holds the largest lag
        beside the subset.
    lags : (K, 2) int64
        Rows down (>= 0) and columns to the right.
    products, pairs : (N, K)
        Filled with the sums, and with the number of pairs of pixels in them.
    """
    width, lanes = weights.shape[1], weights.shape[2]
    radius = (width - 1) // 2
    stride, length = reference.shape[2], width * lanes
    lane_x, box = np.empty(lanes, dtype=np.float32), np.empty(lanes, dtype=np.float32)
    for i in range(lanes):
        lane_x[i] = np.float32(i - radius)
        box[i] = np.float32(1.0)
    room = (width + _largest(lags) + 1) * lanes
    ones, rest = np.zeros(room, dtype=np.float32), np.zeros(room, dtype=np.float32)
    system = np.zeros((10, 4))
    for k in range(points.shape[0]):
        x, y = points[k, 0], points[k, 1]
        told = fit_light(reference, x, y, weights, grey, k, radius, lane_x, box, system) > 0.0
        for first in range(0, width, LANES):
            xs = load(lane_x, first)
            for j in range(width):
                at = (k * width + j) * lanes + first
                weight = load(weights, at)
                known = load(reference, (y - radius + j) * stride + x - radius + first)
                left = residual(
                    known, load(grey, at), xs, spread(float(j - radius)), system[9],
                    weight * spread(1.0 if told else 0.0),
                )  # fmt: skip
                store(ones, j * lanes + first, weight)
                store(rest, j * lanes + first, left)
        for n in range(lags.shape[0]):
            offset = lags[n, 0] * lanes + lags[n, 1]
            products[k, n] = _lag_product(rest, rest, offset, length)
            pairs[k, n] = _lag_product(ones, ones, offset, length)


@inner(forceinline=True)
def _factor_of_slope(part, xs, ys, second):  # type: ignore[no-untyped-def]
    """Polynomial 1, x, y, x^2, x y, y^2 of a block of pixels."""
    value = fused(spread(part[2]), ys, fused(spread(part[1]), xs, spread(part[0])))
    if second is not None:
        value = fused(fused(spread(part[3]), xs, spread(part[4]) * ys), xs, value)
        value = fused(spread(part[5]) * ys, ys, value)
    return value


@inner(fastmath=VECTOR_FLAGS)
def _fill_influence(  # type: ignore[no-untyped-def]
    reference, x, y, weights, k, lane_x, mean, parts, second, influence
) -> None:  # fmt: skip
    """Weight of each pixel's grey in u and v; `parts` are the factors of both slopes and light."""
    width, lanes = weights.shape[1], weights.shape[2]
    radius = (width - 1) // 2
    stride = reference.shape[2]
    plane = reference.shape[1] * stride
    for axis in range(2):
        for first in range(0, width, LANES):
            xs = load(lane_x, first)
            for j in range(width):
                ys = spread(float(j - radius))
                at = (y - radius + j) * stride + x - radius + first
                value = load(reference, at + plane) * _factor_of_slope(
                    parts[axis, 0:6], xs, ys, second
                )
                value = fused(
                    load(reference, at + 2 * plane),
                    _factor_of_slope(parts[axis, 6:12], xs, ys, second),
                    value,
                )
                lit = fused(
                    spread(parts[axis, 13]), load(reference, at) - spread(mean),
                    spread(parts[axis, 12]),
                )  # fmt: skip
                weight = load(weights, (k * width + j) * lanes + first)
                store(influence[axis], j * lanes + first, (value - lit) * weight)


@inner(fastmath=VECTOR_FLAGS)
def _carried_noise(influence, lags, noise, width, lanes, steps, doubled, sums) -> None:  # type: ignore[no-untyped-def]
    """Carry noise of an autocovariance through both rows of weights: variances and covariance.

    `sums` is filled with those of x, y and both, first as white noise of the same strength
    would have them.
    """
    in_x, in_y = influence[0], influence[1]
    for n in range(lags.shape[0]):
        steps[n] = lags[n, 0] * lanes + lags[n, 1]
        doubled[n] = np.float32((1.0 if n == 0 else 2.0) * noise[n])
    white_x = white_y = xx = yy = xy = spread(0.0)
    for j in range(width):
        for first in range(0, width, LANES):
            at = j * lanes + first
            here_x, here_y = load(in_x, at), load(in_y, at)
            far_x = far_y = spread(0.0)
            for n in range(steps.shape[0]):
                by = spread(doubled[n])
                far_x = fused(by, load(in_x, at + steps[n]), far_x)
                far_y = fused(by, load(in_y, at + steps[n]), far_y)
            white_x, white_y = fused(here_x, here_x, white_x), fused(here_y, here_y, white_y)
            xx, yy = fused(here_x, far_x, xx), fused(here_y, far_y, yy)
            xy = fused(here_x, far_y, fused(here_y, far_x, xy))
    sums[0], sums[1] = noise[0] * total(white_x), noise[0] * total(white_y)
    sums[2], sums[3], sums[4] = total(xx), total(yy), 0.5 * total(xy)


@njit(cache=True, nogil=True, error_model="numpy")
def solution_covariance(
    reference: Greys,
    points: Ints,
    weights: Greys,
    order: int,
    second: int | None,
    lags: Ints,
    covariance: Floats,
    least_share: float,
    result: Floats,
    squares: Floats,
) -> None:
    """Covariance of the matched position from the autocovariance of the grey noise.

    Parameters
    ----------
    reference, points, weights, lags
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
    squares : (N, 2)
        Filled with the mean squares of the slopes along x and y; NaN likewise.
    """
    width, lanes = weights.shape[1], weights.shape[2]
    radius = (width - 1) // 2
    terms = (order + 1) * (order + 2) // 2
    influence = np.zeros((2, (width + _largest(lags) + 2) * lanes), dtype=np.float32)
    lane_x = np.empty(lanes, dtype=np.float32)
    for i in range(lanes):
        lane_x[i] = np.float32(i - radius)
    steps, doubled = np.empty(len(lags), np.int64), np.empty(len(lags), np.float32)
    system, parts, sums = np.zeros((31, 15)), np.zeros((2, 14)), np.zeros(5)
    hessian, lower, products = system[0:12], system[12:24], system[24:27]
    total_, along, unit, row = system[27], system[28], system[29], system[30]
    for k in range(points.shape[0]):
        for a in range(3):
            result[k, a] = np.nan
        squares[k, 0], squares[k, 1] = np.nan, np.nan
        x, y = points[k, 0], points[k, 1]
        own = weights[k]
        count = 0.0
        for j in range(width):
            for i in range(width):
                count += own[j, i]
        if count < 4:
            continue
        mean = mean_grey(reference, own, y - radius, x - radius, count)
        reference_moments(
            reference, own, lane_x, y - radius, x - radius, mean, second, products, total_, along
        )
        offset = along[0] / count
        energy = along[1] - along[0] * offset
        if not energy > 0.0:
            continue
        for a in range(3, 15):
            along[a] -= offset * total_[a]
        fill_hessian(products, total_, along, count, energy, terms, hessian)
        if not factor(hessian, 2 * terms, 0.0, lower):
            continue
        for axis in range(2):
            clear(unit)
            unit[axis * terms] = 1.0
            solve(lower, unit, 2 * terms, row)
            clear(parts[axis])
            for a in range(2 * terms):
                at = a if a < terms else 6 + a - terms
                parts[axis, at] = row[a]
                parts[axis, 12] += row[a] * total_[3 + at] / count
                parts[axis, 13] += row[a] * along[3 + at] / energy
        _fill_influence(
            reference, x, y, weights, k, lane_x, float(mean) + offset, parts, second, influence
        )
        _carried_noise(influence, lags, covariance[k], width, lanes, steps, doubled, sums)
        xx, yy = max(sums[2], least_share * sums[0]), max(sums[3], least_share * sums[1])
        limit = np.sqrt(xx * yy)
        result[k, 0], result[k, 1] = xx, yy
        squares[k, 0], squares[k, 1] = products[0, 0] / count, products[2, 0] / count
        result[k, 2] = min(max(sums[4], -limit), limit)
