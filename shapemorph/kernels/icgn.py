"""Inverse compositional Gauss-Newton matching of subsets.

One loop for shape functions of order 0, 1 and 2: the warp is data. Every point is
matched on its own, from its own start, so the result does not depend on the order or
the number of threads.

The criterion is ZNSSD, i.e. the zero-mean normalised cross-correlation. Gain and offset
of the grey are eliminated exactly: Hessian and right-hand side are those of the
normalised residual, not of the raw one.
"""

from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shapemorph.core.arrays import Codes, Floats, Greys, Ints
from shapemorph.core.status import PointStatus
from shapemorph.kernels.inner import inner
from shapemorph.kernels.small_linear import clear, compose_with_inverse, copy, factor, solve
from shapemorph.kernels.subset_box import pixels_inside, whole_box
from shapemorph.kernels.subset_hessian import fill_hessian, mean_grey, reference_moments
from shapemorph.kernels.subset_rows import warped_moments
from shapemorph.kernels.vectors import LANES

Counts: TypeAlias = NDArray[np.int32]

OK = int(PointStatus.OK)
LEFT_IMAGE = int(PointStatus.LEFT_IMAGE)
LOW_CONTRAST = int(PointStatus.LOW_CONTRAST)
NOT_CONVERGED = int(PointStatus.NOT_CONVERGED)
LOW_ZNCC = int(PointStatus.LOW_ZNCC)

HOPELESS_AFTER = 4  # iterations
HOPELESS_ZNCC = 0.25
WORSE = 1e-3  # a step that loses more ZNCC than this is taken back and damped
MAX_DAMPING = 1e4
FADED = 0.1  # the deformed subset may have so much less contrast than the reference must have

SHRINKING = 0.25  # steps that shrink at least so much go on shrinking
SLOW_AFTER, SLOW_AGAIN = 6, 3  # iterations before steps are lengthened, and between two of them
ALIKE = 0.8  # squared cosine between steps that go on in one direction
SLOWEST = 0.97  # ratio between such steps that is believed

_ZERO = np.float32(0.0)
_ONE = np.float32(1.0)


@inner()
def _load_weights(inside, counts, row, col, weights, is_full) -> tuple[float, bool]:  # type: ignore[no-untyped-def]
    """Copy the mask of a subset; return the number of pixels that count, and if all do."""
    width = weights.shape[0]
    found = pixels_inside(counts, col, row, col + width, row + width)
    full = found == width * width
    if not (full and is_full):
        for j in range(width):
            for i in range(width):
                weights[j, i] = _ONE if full else inside[row + j, col + i]
    return float(found), full


@inner()
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


@inner()
def _corner_motion(step, radius) -> float:  # type: ignore[no-untyped-def]
    """Bound of the motion of any corner of the subset, px."""
    r, rr = float(radius), float(radius * radius)
    motion = 0.0
    for half in (0, 6):
        part = abs(step[half]) + r * (abs(step[half + 1]) + abs(step[half + 2]))
        part += rr * (abs(step[half + 3]) + abs(step[half + 4]) + abs(step[half + 5]))
        motion += part * part
    return float(np.sqrt(motion))


@inner()
def _settled(motion, last_motion, tolerance) -> bool:  # type: ignore[no-untyped-def]
    """Tell if all steps to come, shrinking as the last one did, stay below half the tolerance."""
    left = last_motion - motion
    return bool(motion < SHRINKING * last_motion and motion * motion < 0.5 * tolerance * left)


@inner()
def _steps_to_come(step, last, radius) -> float:  # type: ignore[no-untyped-def]
    """Sum all steps of a geometric series, this one as unit; 1 where it is none.

    Noise in the gradients of a pattern that is faint in one direction (grain) makes every
    step too short by the same factor.
    """
    r = float(radius)
    both, one, other = 0.0, 0.0, 0.0
    for a in range(12):
        term = a % 6
        weight = 1.0 if term == 0 else (r * r if term < 3 else r * r * r * r)
        both += weight * step[a] * last[a]
        one += weight * step[a] * step[a]
        other += weight * last[a] * last[a]
    if not (both > 0.0 and both * both > ALIKE * one * other and one < other):
        return 1.0
    return float(1.0 / (1.0 - min(np.sqrt(one / other), SLOWEST)))


@njit(inline="always")
def _match_one(  # type: ignore[no-untyped-def]
    reference, inside, counts, coefficients, wide, other_inside, other_counts, x, y, warp,
    radius, order, second, tolerance, max_iterations, min_count, min_deviation, max_drift,
    lane_x, weights, is_full, system,
) -> tuple[int, float, int, bool]:  # fmt: skip
    """Match one point; `warp` is its start and becomes its result."""
    hessian, lower, products = system[0:12], system[12:24], system[24:27]
    total, along, moments, right = system[27], system[28], system[29], system[30]
    best_right, step, best, trial = system[31], system[32, :12], system[33, :12], system[34, :12]
    solution, last_step = system[35], system[36, :12]
    terms = (order + 1) * (order + 2) // 2
    unknowns = 2 * terms
    row, col = y - radius, x - radius
    min_energy = min_deviation * min_deviation

    count, full = _load_weights(inside, counts, row, col, weights, is_full)
    if count < min_count:
        return LOW_CONTRAST, np.nan, 0, full
    fresh, damping = True, 0.0
    mean, offset, energy = _ZERO, 0.0, 0.0
    best_zncc = -2.0
    start_x, start_y = warp[0], warp[6]
    last_motion, last_long = 0.0, SLOW_AFTER
    for iteration in range(1, max_iterations + 1):
        where = whole_box(other_counts, x, y, warp, radius)
        if where == 0:
            return LEFT_IMAGE, np.nan, iteration, full
        if where == 1:
            count, dropped = _limit_weights(other_inside, x, y, warp, radius, weights)
            full = full and not dropped
            fresh = fresh or dropped
            if count < min_count:
                return LEFT_IMAGE, np.nan, iteration, full
        if fresh:
            mean = mean_grey(reference, weights, row, col, count)
            reference_moments(
                reference, weights, lane_x, row, col, mean, second, products, total, along
            )
            offset = along[0] / count
            energy = along[1] - along[0] * offset
            if not energy > count * min_energy:
                return LOW_CONTRAST, np.nan, iteration, full
            for a in range(3, 15):
                along[a] -= offset * total[a]
            fill_hessian(products, total, along, count, energy, terms, hessian)
            if not factor(hessian, unknowns, damping, lower):
                return LOW_CONTRAST, np.nan, iteration, full
            fresh = False
            best_zncc = -2.0

        warped_moments(
            coefficients, wide, x, y, warp, radius, second, reference, weights, lane_x, mean,
            moments,
        )  # fmt: skip
        found = moments[0] / count
        found_energy = moments[1] - moments[0] * found
        if not found_energy > count * min_energy * FADED * FADED:
            return LOW_CONTRAST, np.nan, iteration, full
        shared = moments[2] - (float(mean) + offset) * moments[0]
        gain = np.sqrt(energy / found_energy)
        zncc = shared * gain / energy

        if zncc < best_zncc - WORSE:
            damping = max(10.0 * damping, 0.1)
            if damping > MAX_DAMPING:
                copy(best, warp)
                return NOT_CONVERGED, best_zncc, iteration, full
            factor(hessian, unknowns, damping, lower)
            copy(best, warp)
            copy(best_right, right)
        else:
            if damping > 0.0:
                damping = 0.1 * damping if damping > 1e-3 else 0.0
                factor(hessian, unknowns, damping, lower)
            best_zncc = zncc
            copy(warp, best)
            for a in range(unknowns):
                at = 3 + a if a < terms else 9 + a - terms
                right[a] = gain * (moments[at] - found * total[at]) - zncc * along[at]
            copy(right, best_right)
        if iteration >= HOPELESS_AFTER and best_zncc < HOPELESS_ZNCC:
            return LOW_ZNCC, best_zncc, iteration, full

        solve(lower, right, unknowns, solution)
        clear(step)
        for a in range(terms):
            step[a] = solution[a]
            step[6 + a] = solution[terms + a]
        if damping == 0.0 and iteration >= last_long + SLOW_AGAIN - 1:
            to_come = _steps_to_come(step, last_step, radius)
            copy(step, last_step)
            if iteration >= last_long + SLOW_AGAIN and to_come > 1.0:
                last_long = iteration
                for a in range(12):
                    step[a] *= to_come
        compose_with_inverse(warp, step, second, trial)
        copy(trial, warp)
        drift_x, drift_y = warp[0] - start_x, warp[6] - start_y
        if not drift_x * drift_x + drift_y * drift_y <= max_drift * max_drift:
            return NOT_CONVERGED, best_zncc, iteration, full
        motion = _corner_motion(step, radius)
        if motion < tolerance * (1.0 if damping == 0.0 else 0.01) or (
            damping == 0.0 and _settled(motion, last_motion, tolerance)
        ):
            gained = 0.0
            for a in range(unknowns):
                gained += right[a] * solution[a]
            return OK, min(np.sqrt(best_zncc**2 + gained / energy), 1.0), iteration, full
        last_motion = motion if damping == 0.0 else 0.0
    return NOT_CONVERGED, best_zncc, max_iterations, full


@njit(cache=True, nogil=True, error_model="numpy")
def match_subsets(
    reference: Greys,
    inside: Greys,
    counts: Counts,
    coefficients: Greys,
    wide: int | None,
    other_inside: Greys,
    other_counts: Counts,
    points: Ints,
    radius: int,
    order: int,
    second: int | None,
    tolerance: float,
    max_iterations: int,
    min_count: float,
    min_deviation: float,
    max_drift: float,
    warps: Floats,
    zncc: Floats,
    iterations: Ints,
    outcome: Codes,
) -> None:
    """Match subsets of the reference picture in the deformed picture.

    All pictures carry the same padding, wide enough that no subset of the reference
    leaves it; a warped subset that does is LEFT_IMAGE.

    Parameters
    ----------
    reference : (3, H, W) float32
        Grey and its derivatives along x and y.
    inside : (H, W) float32
        1 where a pixel of the reference counts, else 0.
    counts : (H + 1, W + 1) int32
        Number of those pixels above and left of each corner.
    coefficients : (H, W) float32
        B-spline coefficients of the deformed picture.
    wide : None or int
        None where they are those of a cubic spline, any number for a quintic one.
    other_inside, other_counts
        The same as for the reference, of the deformed picture.
    points : (N, 2) int64
        Centres (x, y) of the subsets.
    radius, order : int
        Half width of the subset, px; order of the shape function, 0, 1 or 2.
    second : None or int
        None for order 0 and 1: the terms of second degree are compiled only where needed.
    tolerance : float
        Stop when no corner moves farther, px.
    max_iterations : int
    min_count : float
        Fewest pixels of a subset that must count.
    min_deviation : float
        Least standard deviation of the grey in a subset.
    max_drift : float
        Farthest a centre may move from its start, px.
    warps : (N, 12)
        In: the start of each point, its position in the deformed picture relative to the
        centre, x then y, as coefficients of 1, x, y, x^2, x y, y^2 in px; terms above
        `order` stay. Out: the last estimate, whatever the outcome.
    zncc : (N,)
        Filled; NaN where it was never computed.
    iterations : (N,) int64
        Filled.
    outcome : (N,) uint8
        Filled with a PointStatus: OK, LEFT_IMAGE, LOW_CONTRAST, NOT_CONVERGED, LOW_ZNCC.
    """
    width = 2 * radius + 1
    lanes = (width + LANES - 1) // LANES * LANES
    lane_x = np.empty(lanes, dtype=np.float32)
    for i in range(lanes):
        lane_x[i] = np.float32(i - radius)
    weights = np.zeros((width, lanes), dtype=np.float32)
    system = np.zeros((37, 15))
    full = width < 0  # of no kind that is compiled for itself, as False would be
    for k in range(points.shape[0]):
        outcome[k], zncc[k], iterations[k], full = _match_one(
            reference, inside, counts, coefficients, wide, other_inside, other_counts,
            points[k, 0], points[k, 1], warps[k], radius, order, second, tolerance,
            max_iterations, min_count, min_deviation, max_drift, lane_x, weights, full,
            system,
        )  # fmt: skip
