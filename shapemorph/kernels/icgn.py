"""Inverse compositional Gauss-Newton matching of subsets.

One loop for shape functions of order 0, 1 and 2: the warp is data. Every point is
matched on its own, from its own start, so the result does not depend on the order or
the number of threads.

The criterion is ZNSSD, i.e. the zero-mean normalised cross-correlation. Gain and offset
of the grey are eliminated exactly: Hessian and right-hand side are those of the
normalised residual, not of the raw one.
"""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Codes, Floats, Greys, Ints
from shapemorph.core.status import PointStatus
from shapemorph.kernels.small_linear import compose_with_inverse, factor, solve
from shapemorph.kernels.subset_rows import VECTOR_FLAGS, interpolate_subset

OK = int(PointStatus.OK)
LEFT_IMAGE = int(PointStatus.LEFT_IMAGE)
LOW_CONTRAST = int(PointStatus.LOW_CONTRAST)
NOT_CONVERGED = int(PointStatus.NOT_CONVERGED)
LOW_ZNCC = int(PointStatus.LOW_ZNCC)

BLOCK = 32  # points that share one set of buffers
MARGIN = 3  # px that the spline needs around a warped subset
HOPELESS_AFTER = 4  # iterations
HOPELESS_ZNCC = 0.25
WORSE = 1e-3  # a step that loses more ZNCC than this is taken back and damped
MAX_DAMPING = 1e4

_ZERO = np.float32(0.0)


@njit(cache=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _dot(a: Greys, b: Greys) -> float:
    total = _ZERO
    for i in range(a.shape[0]):
        total += a[i] * b[i]
    return float(total)


@njit(cache=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _load_weights(inside, row, col, weights) -> float:  # type: ignore[no-untyped-def]
    """Copy the mask of a subset; return the number of pixels that count."""
    width = weights.shape[0]
    total = _ZERO
    for j in range(width):
        line, source = weights[j], inside[row + j, col : col + width]
        for i in range(width):
            line[i] = source[i]
            total += source[i]
    return float(total)


@njit(cache=True, error_model="numpy")
def _limit_weights(inside, x, y, warp, radius, weights) -> tuple[float, bool]:  # type: ignore[no-untyped-def]
    """Drop the pixels whose match is outside; return the number left, and if any was dropped."""
    height, length = inside.shape
    total, changed = 0.0, False
    for j in range(weights.shape[0]):
        b = float(j - radius)
        for i in range(2 * radius + 1):
            if weights[j, i] == _ZERO:
                continue
            a = float(i - radius)
            at_x = warp[0] + warp[1] * a + warp[2] * b
            at_x += warp[3] * a * a + warp[4] * a * b + warp[5] * b * b
            at_y = warp[6] + warp[7] * a + warp[8] * b
            at_y += warp[9] * a * a + warp[10] * a * b + warp[11] * b * b
            col, row = int(np.floor(x + at_x + 0.5)), int(np.floor(y + at_y + 0.5))
            within = 0 <= col < length and 0 <= row < height
            if within and inside[row, col] > _ZERO:
                total += 1.0
            else:
                weights[j, i] = _ZERO
                changed = True
    return total, changed


@njit(cache=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _load_pattern(reference, row, col, weights, count, pattern) -> float:  # type: ignore[no-untyped-def]
    """Copy the grey of a subset less its mean, which is returned."""
    width = weights.shape[0]
    total = _ZERO
    for j in range(width):
        line, weight, source = pattern[j], weights[j], reference[0, row + j, col : col + width]
        for i in range(width):
            line[i] = source[i] * weight[i]
            total += line[i]
    mean = total / np.float32(count)
    for j in range(width):
        line, weight = pattern[j], weights[j]
        for i in range(width):
            line[i] -= mean * weight[i]
    return float(mean)


@njit(cache=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _load_descent(reference, row, col, weights, lane_x, terms, images) -> None:  # type: ignore[no-untyped-def]
    """Fill the steepest-descent images: grey gradient times the terms of the warp."""
    width, lanes = weights.shape
    for j in range(width):
        y = lane_x[j]
        weight = weights[j]
        for axis in range(2):
            source = reference[1 + axis, row + j, col : col + width]
            base = axis * terms
            first = images[base, j * lanes : (j + 1) * lanes]
            for i in range(width):
                first[i] = source[i] * weight[i]
            if terms >= 3:
                second = images[base + 1, j * lanes : (j + 1) * lanes]
                third = images[base + 2, j * lanes : (j + 1) * lanes]
                for i in range(width):
                    second[i] = first[i] * lane_x[i]
                    third[i] = first[i] * y
            if terms == 6:
                xx = images[base + 3, j * lanes : (j + 1) * lanes]
                xy = images[base + 4, j * lanes : (j + 1) * lanes]
                yy = images[base + 5, j * lanes : (j + 1) * lanes]
                for i in range(width):
                    xx[i] = second[i] * lane_x[i]
                    xy[i] = second[i] * y
                    yy[i] = third[i] * y


@njit(cache=True, error_model="numpy")
def _prepare(images, weights, pattern, count, total, energy, along, hessian) -> None:  # type: ignore[no-untyped-def]
    """Hessian of the normalised residual, and the pattern's share in each descent image."""
    unknowns = images.shape[0]
    for a in range(unknowns):
        total[a] = _dot(images[a], weights)
        along[a] = _dot(images[a], pattern)
        for b in range(a + 1):
            hessian[a, b] = (
                _dot(images[a], images[b])
                - total[a] * total[b] / count
                - along[a] * along[b] / energy
            )


@njit(cache=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _statistics(samples, weights, pattern, mean) -> tuple[float, float, float]:  # type: ignore[no-untyped-def]
    """Shift and mask the samples in place; return their sum, energy and share of the pattern."""
    shift = np.float32(mean)
    total, energy, shared = _ZERO, _ZERO, _ZERO
    for i in range(samples.shape[0]):
        value = (samples[i] - shift) * weights[i]
        samples[i] = value
        total += value
        energy += value * value
        shared += value * pattern[i]
    return float(total), float(energy), float(shared)


@njit(cache=True, error_model="numpy")
def _whole_box(counts, inside, x, y, warp, radius, spare) -> int:  # type: ignore[no-untyped-def]
    """Tell if the warped subset is inside (2), partly inside (1) or beyond reach (0)."""
    r, rr = float(radius), float(radius * radius)
    half_x = r * (abs(warp[1]) + abs(warp[2]))
    half_x += rr * (abs(warp[3]) + abs(warp[4]) + abs(warp[5]))
    half_y = r * (abs(warp[7]) + abs(warp[8]))
    half_y += rr * (abs(warp[9]) + abs(warp[10]) + abs(warp[11]))
    low_x, high_x = x + warp[0] - half_x, x + warp[0] + half_x
    low_y, high_y = y + warp[6] - half_y, y + warp[6] + half_y
    height, length = inside.shape
    if not (
        low_x >= MARGIN
        and low_y >= MARGIN
        and high_x < length - MARGIN - spare
        and high_y < height - MARGIN
    ):
        return 0
    left, right = int(np.floor(low_x + 0.5)), int(np.floor(high_x + 0.5)) + 1
    top, bottom = int(np.floor(low_y + 0.5)), int(np.floor(high_y + 0.5)) + 1
    found = counts[bottom, right] - counts[top, right] - counts[bottom, left] + counts[top, left]
    return 2 if found == (right - left) * (bottom - top) else 1


@njit(cache=True, error_model="numpy")
def _corner_motion(step, radius) -> float:  # type: ignore[no-untyped-def]
    """Bound of the motion of any corner of the subset, px."""
    r, rr = float(radius), float(radius * radius)
    motion = 0.0
    for half in (0, 6):
        part = abs(step[half]) + r * (abs(step[half + 1]) + abs(step[half + 2]))
        part += rr * (abs(step[half + 3]) + abs(step[half + 4]) + abs(step[half + 5]))
        motion += part * part
    return float(np.sqrt(motion))


@njit(cache=True, error_model="numpy")
def _match_one(  # type: ignore[no-untyped-def]
    reference, coefficients, inside, counts, x, y, warp, radius, order, tolerance,
    max_iterations, min_count, min_deviation, max_drift, lane_x, steps, planes, images, system,
) -> tuple[int, float, int]:  # fmt: skip
    """Match one point; `warp` is its start and becomes its result."""
    weights, pattern, samples = planes[0], planes[1], planes[2]
    flat_weights, flat_pattern = weights.reshape(-1), pattern.reshape(-1)
    flat_samples = samples.reshape(-1)
    hessian, lower, vectors = system[0], system[1], system[2]
    total, along, right, solution = vectors[0], vectors[1], vectors[2], vectors[3]
    best_right, step, best, trial = vectors[4], vectors[5], vectors[6], vectors[7]
    terms = (order + 1) * (order + 2) // 2
    unknowns = 2 * terms
    width, lanes = weights.shape
    row, col = y - radius, x - radius

    count = _load_weights(inside[0], row, col, weights[:, :width])
    if count < min_count:
        return LOW_CONTRAST, np.nan, 0
    fresh, damping = True, 0.0
    mean = energy = 0.0
    best_zncc = -2.0
    start_x, start_y = warp[0], warp[6]
    for iteration in range(1, max_iterations + 1):
        where = _whole_box(counts, inside[1], x, y, warp, radius, lanes - width)
        if where == 0:
            return LEFT_IMAGE, np.nan, iteration
        if where == 1:
            count, dropped = _limit_weights(inside[1], x, y, warp, radius, weights)
            fresh = fresh or dropped
            if count < min_count:
                return LEFT_IMAGE, np.nan, iteration
        if fresh:
            mean = _load_pattern(
                reference, row, col, weights[:, :width], count, pattern[:, :width]
            )
            energy = _dot(flat_pattern, flat_pattern)
            if not energy > count * min_deviation * min_deviation:
                return LOW_CONTRAST, np.nan, iteration
            _load_descent(reference, row, col, weights, lane_x, terms, images)
            _prepare(
                images, flat_weights, flat_pattern, count, total, energy, along, hessian
            )
            if not factor(hessian, unknowns, damping, lower):
                return LOW_CONTRAST, np.nan, iteration
            fresh = False
            best_zncc = -2.0

        interpolate_subset(coefficients, x, y, warp, radius, lane_x, steps, samples)
        found, found_energy, shared = _statistics(flat_samples, flat_weights, flat_pattern, mean)
        found_energy -= found * found / count
        if not found_energy > count * min_deviation * min_deviation * 0.01:
            return LOW_CONTRAST, np.nan, iteration
        norm, found_norm = np.sqrt(energy), np.sqrt(found_energy)
        zncc = shared / (norm * found_norm)

        if zncc < best_zncc - WORSE:
            damping = max(10.0 * damping, 0.1)
            if damping > MAX_DAMPING:
                warp[:] = best
                return NOT_CONVERGED, best_zncc, iteration
            factor(hessian, unknowns, damping, lower)
            warp[:] = best
            right[:] = best_right
        else:
            if damping > 0.0:
                damping = 0.1 * damping if damping > 1e-3 else 0.0
                factor(hessian, unknowns, damping, lower)
            best_zncc = zncc
            best[:] = warp
            for a in range(unknowns):
                across = _dot(images[a], flat_samples) - total[a] * found / count
                right[a] = across * (norm / found_norm) - zncc * along[a]
            best_right[:] = right
        if iteration >= HOPELESS_AFTER and best_zncc < HOPELESS_ZNCC:
            return LOW_ZNCC, best_zncc, iteration

        solve(lower, right, unknowns, solution)
        step[:] = 0.0
        for a in range(terms):
            step[a] = solution[a]
            step[6 + a] = solution[terms + a]
        compose_with_inverse(warp, step, order == 2, trial)
        warp[:] = trial
        drift_x, drift_y = warp[0] - start_x, warp[6] - start_y
        if not drift_x * drift_x + drift_y * drift_y <= max_drift * max_drift:
            return NOT_CONVERGED, best_zncc, iteration
        if _corner_motion(step, radius) < tolerance * (1.0 if damping == 0.0 else 0.01):
            return OK, best_zncc, iteration
    return NOT_CONVERGED, best_zncc, max_iterations


@njit(cache=True, parallel=True, error_model="numpy")
def match_subsets(
    reference: Greys,
    coefficients: Greys,
    inside: Greys,
    counts: np.ndarray,  # type: ignore[type-arg]
    points: Ints,
    starts: Floats,
    radius: int,
    order: int,
    tolerance: float,
    max_iterations: int,
    min_count: float,
    min_deviation: float,
    max_drift: float,
) -> tuple[Floats, Floats, Ints, Codes]:
    """Match subsets of the reference picture in the deformed picture.

    All pictures carry the same padding, wide enough that no subset of the reference
    leaves it; a warped subset that does is LEFT_IMAGE.

    Parameters
    ----------
    reference : (3, H, W) float32
        Grey and its derivatives along x and y.
    coefficients : (H, W) float32
        Cubic B-spline coefficients of the deformed picture.
    inside : (2, H, W) float32
        1 where a pixel of the reference, of the deformed picture counts, else 0.
    counts : (H + 1, W + 1) int32
        Number of pixels of ``inside[1]`` above and left of each corner.
    points : (N, 2) int64
        Centres (x, y) of the subsets.
    starts : (N, 12)
        Start of each warp: position in the deformed picture relative to the centre, x
        then y, as coefficients of 1, x, y, x^2, x y, y^2 in px. Terms above `order` stay.
    radius, order : int
        Half width of the subset, px; order of the shape function, 0, 1 or 2.
    tolerance : float
        Stop when no corner moves farther, px.
    max_iterations : int
    min_count : float
        Fewest pixels of a subset that must count.
    min_deviation : float
        Least standard deviation of the grey in a subset.
    max_drift : float
        Farthest a centre may move from its start, px.

    Returns
    -------
    warps : (N, 12)
        The last estimate, whatever the outcome.
    zncc : (N,)
        NaN where it was never computed.
    iterations : (N,) int64
    outcome : (N,) uint8
        A PointStatus: OK, LEFT_IMAGE, LOW_CONTRAST, NOT_CONVERGED, LOW_ZNCC.
    """
    number = points.shape[0]
    width = 2 * radius + 1
    lanes = (width + 7) // 8 * 8
    unknowns = (order + 1) * (order + 2)
    warps = starts.copy()
    zncc = np.full(number, np.nan)
    iterations = np.zeros(number, dtype=np.int64)
    outcome = np.zeros(number, dtype=np.uint8)
    for block in prange((number + BLOCK - 1) // BLOCK):
        lane_x = np.empty(lanes, dtype=np.float32)
        for i in range(lanes):
            lane_x[i] = np.float32(i - radius)
        steps = np.arange(5).astype(np.uint64)
        planes = np.zeros((3, width, lanes), dtype=np.float32)
        images = np.zeros((unknowns, width * lanes), dtype=np.float32)
        system = np.zeros((3, 12, 12))
        for k in range(block * BLOCK, min((block + 1) * BLOCK, number)):
            outcome[k], zncc[k], iterations[k] = _match_one(
                reference, coefficients, inside, counts, points[k, 0], points[k, 1], warps[k],
                radius, order, tolerance, max_iterations, min_count, min_deviation, max_drift,
                lane_x, steps, planes, images, system,
            )  # fmt: skip
    return warps, zncc, iterations, outcome
