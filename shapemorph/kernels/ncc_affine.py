"""Affine matching of subsets by a quadratic model of their normalised cross-correlation.

The criterion is only ever evaluated, never differentiated: its second-order polynomial comes
from values on a stencil, and its maximum, kept in a box, is the next step (sequential
quadratic programming with bounds).
"""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Codes, Floats, Greys, Ints
from shapemorph.core.status import PointStatus
from shapemorph.kernels.bspline import cubic_weights
from shapemorph.kernels.small_linear import factor, solve

OK = int(PointStatus.OK)
LEFT_IMAGE = int(PointStatus.LEFT_IMAGE)
NOT_CONVERGED = int(PointStatus.NOT_CONVERGED)

STENCIL = 0.5  # px of motion, of the centre or of the edge of the subset
LONGEST = 1.0  # px: a step changes no parameter by more
MAX_DAMPING = 1e3
SIZE = 6


@njit(cache=True, error_model="numpy")
def _likeness(  # type: ignore[no-untyped-def]
    reference, reference_inside, coefficients, inside, x, y, part, radius, least
) -> float:
    """NCC of a subset with its match; NaN where too few pixels count."""
    height, width = coefficients.shape
    number, sum_f, sum_g, sum_ff, sum_gg, sum_fg = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for b in range(-radius, radius + 1):
        beside = b / radius
        for a in range(-radius, radius + 1):
            if not reference_inside[y + b, x + a] > 0.0:
                continue
            along = a / radius
            at_x = x + a + part[0] + part[1] * along + part[2] * beside
            at_y = y + b + part[3] + part[4] * along + part[5] * beside
            if not (1.0 <= at_x < width - 2.0 and 1.0 <= at_y < height - 2.0):
                continue
            if not inside[int(at_y + 0.5), int(at_x + 0.5)] > 0.0:
                continue
            col, row = int(at_x), int(at_y)
            wx, wy = cubic_weights(at_x - col), cubic_weights(at_y - row)
            g = 0.0
            for j in range(4):
                line = 0.0
                for i in range(4):
                    line += wx[i] * coefficients[row - 1 + j, col - 1 + i]
                g += wy[j] * line
            f = float(reference[y + b, x + a])
            number += 1.0
            sum_f += f
            sum_g += g
            sum_ff += f * f
            sum_gg += g * g
            sum_fg += f * g
    if number < least:
        return np.nan
    spread = (sum_ff - sum_f * sum_f / number) * (sum_gg - sum_g * sum_g / number)
    if not spread > 1e-12 * number * number:
        return np.nan
    return float((sum_fg - sum_f * sum_g / number) / np.sqrt(spread))


@njit(cache=True, error_model="numpy", nogil=True)
def refine_affine(
    reference: Greys,
    reference_inside: Greys,
    coefficients: Greys,
    inside: Greys,
    points: Ints,
    radius: int,
    tolerance: float,
    max_iterations: int,
    least: float,
    max_drift: float,
    warps: Floats,
    zncc: Floats,
    iterations: Ints,
    status: Codes,
) -> None:
    """Maximise the normalised cross-correlation over affine maps of the subset.

    Parameters
    ----------
    reference, reference_inside, coefficients, inside : (H, W) float32
        Grey and counting pixels of the reference; spline coefficients and counting pixels
        of the deformed picture; padded alike.
    points : (N, 2)
        Centres (x, y) in the padded pictures.
    radius : int
    tolerance : float
        Settled when no parameter moves the edge of the subset farther, px.
    max_iterations : int
    least : float
        Fewest pixels that must count.
    max_drift : float
        Farthest that the centre may move from its start, px.
    warps : (N, 12)
        First guess; becomes the result.
    zncc, iterations, status : (N,)
        Filled.

    References
    ----------
    Genovese, Sorgente (2017), Eq. 1, doi:10.1016/j.optlaseng.2017.06.020.
    """
    size = float(radius)
    scales = (1.0, size, size, 1.0, size, size)
    ones = (0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    places = (0, 1, 2, 6, 7, 8)
    part, start, trial, step = np.empty(SIZE), np.empty(SIZE), np.empty(SIZE), np.empty(SIZE)
    up, down = np.empty(SIZE), np.empty(SIZE)
    slope, curve, lower = np.empty(SIZE), np.zeros((SIZE, SIZE)), np.zeros((SIZE, SIZE))
    for p in range(points.shape[0]):
        x, y = points[p, 0], points[p, 1]
        for k in range(SIZE):
            part[k] = (warps[p, places[k]] - ones[k]) * scales[k]
            start[k] = part[k]
        best = _likeness(
            reference, reference_inside, coefficients, inside, x, y, part, radius, least
        )
        status[p] = LEFT_IMAGE if np.isnan(best) else NOT_CONVERGED
        iterations[p] = 0
        while status[p] == NOT_CONVERGED and iterations[p] < max_iterations:
            iterations[p] += 1
            for k in range(SIZE):
                trial[:] = part
                trial[k] = part[k] + STENCIL
                up[k] = _likeness(
                    reference, reference_inside, coefficients, inside, x, y, trial, radius, least
                )
                trial[k] = part[k] - STENCIL
                down[k] = _likeness(
                    reference, reference_inside, coefficients, inside, x, y, trial, radius, least
                )
                slope[k] = (up[k] - down[k]) / (2.0 * STENCIL)
                curve[k, k] = -(up[k] - 2.0 * best + down[k]) / STENCIL**2
            if iterations[p] == 1:  # mixed terms change little on the way
                for k in range(SIZE):
                    for m in range(k):
                        trial[:] = part
                        trial[k] += STENCIL
                        trial[m] += STENCIL
                        both = _likeness(
                            reference, reference_inside, coefficients, inside, x, y, trial,
                            radius, least,
                        )  # fmt: skip
                        curve[k, m] = -(both - up[k] - up[m] + best) / STENCIL**2
            damping = 0.0
            while not factor(curve, SIZE, damping, lower) and damping < MAX_DAMPING:
                damping = max(10.0 * damping, 1e-2)
            if not damping < MAX_DAMPING:  # no maximum near, or the stencil leaves the picture
                break
            solve(lower, slope, SIZE, step)
            longest = np.abs(step).max()
            if longest > LONGEST:
                step *= LONGEST / longest
                longest = LONGEST
            while True:
                trial[:] = part + step
                value = _likeness(
                    reference, reference_inside, coefficients, inside, x, y, trial, radius, least
                )
                if value >= best or longest < tolerance:
                    break
                step *= 0.5
                longest *= 0.5
            if value >= best:
                part[:] = trial
                best = value
            if np.hypot(part[0] - start[0], part[3] - start[3]) > max_drift:
                break
            if longest < tolerance:
                status[p] = OK
        zncc[p] = best
        for k in range(SIZE):
            warps[p, places[k]] = part[k] / scales[k] + ones[k]
