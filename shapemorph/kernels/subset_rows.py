"""Interpolation of a deformed picture over the rows of one subset.

A subset is kept in buffers of `lanes` columns, a multiple of eight; the columns beyond
its width have weight zero. Near the identity the 4 x 4 spline supports of neighbouring
pixels in a row are neighbours too, so a row is read as contiguous runs instead of
being gathered pixel by pixel; a row in which the support jumps once is read with five
columns and rows, of which the weights switch four on.

Only integer arithmetic on unsigned types and typed float32 constants keep these loops
in vector registers: a plain literal would turn them into float64, a signed index adds
a test for negative positions. The offsets of the taps come from an array, because with
literal offsets the compiler reuses the loads of the previous pixel by shuffling
registers, which is slower than loading again.
"""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats, Greys

CHUNK = 8  # lanes that are tested together where a whole row cannot be
SLACK = 0.02  # how far a spline piece is used beyond its end: off by 1e-5 of the contrast
VECTOR_FLAGS = {"reassoc", "contract", "nsz", "arcp"}  # NaN and infinity keep their meaning

_ONE = np.float32(1.0)
_HALF = np.float32(0.5)
_TWO = np.float32(2.0)
_SIXTH = np.float32(1.0 / 6.0)
_TWO_THIRDS = np.float32(2.0 / 3.0)
_ZERO = np.float32(0.0)


@njit(inline="always")
def _weights(t: float) -> tuple[float, float, float, float]:
    """Weights of the four knots around offset t, in float32."""
    s = _ONE - t
    left = _TWO_THIRDS - _HALF * t * t * (_TWO - t)
    right = _TWO_THIRDS - _HALF * s * s * (_TWO - s)
    return s * s * s * _SIXTH, left, right, t * t * t * _SIXTH


@njit(inline="always")
def _weights_across(t: float) -> tuple[float, float, float, float, float]:
    """Weights of five knots for an offset t in [0, 2)."""
    beyond = t >= _ONE
    a, b, c, d = _weights(t - _ONE if beyond else t)
    return (
        _ZERO if beyond else a,
        a if beyond else b,
        b if beyond else c,
        c if beyond else d,
        d if beyond else _ZERO,
    )


@njit(cache=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _run_of_four(coefficients, row, col, path_x, path_y, lane_x, steps, first, last, out):  # type: ignore[no-untyped-def]
    """Interpolate lanes whose supports advance by one column each."""
    ax, bx, ex = np.float32(path_x[0]), np.float32(path_x[1]), np.float32(path_x[2])
    ay, by, ey = np.float32(path_y[0]), np.float32(path_y[1]), np.float32(path_y[2])
    c0, c1, c2, c3 = (
        coefficients[row],
        coefficients[row + 1],
        coefficients[row + 2],
        coefficients[row + 3],
    )
    start = np.uint64(col)
    k0, k1, k2, k3 = start + steps[0], start + steps[1], start + steps[2], start + steps[3]
    for i in range(np.uint64(first), np.uint64(last)):
        x = lane_x[i]
        p0, p1, p2, p3 = _weights(ax + x * (bx + ex * x))
        q0, q1, q2, q3 = _weights(ay + x * (by + ey * x))
        out[i] = (
            q0 * (p0 * c0[k0 + i] + p1 * c0[k1 + i] + p2 * c0[k2 + i] + p3 * c0[k3 + i])
            + q1 * (p0 * c1[k0 + i] + p1 * c1[k1 + i] + p2 * c1[k2 + i] + p3 * c1[k3 + i])
            + q2 * (p0 * c2[k0 + i] + p1 * c2[k1 + i] + p2 * c2[k2 + i] + p3 * c2[k3 + i])
            + q3 * (p0 * c3[k0 + i] + p1 * c3[k1 + i] + p2 * c3[k2 + i] + p3 * c3[k3 + i])
        )


@njit(cache=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _run_of_five(coefficients, row, col, path_x, path_y, lane_x, steps, first, last, out):  # type: ignore[no-untyped-def]
    """Interpolate lanes whose supports jump by one column or row at most once."""
    ax, bx, ex = np.float32(path_x[0]), np.float32(path_x[1]), np.float32(path_x[2])
    ay, by, ey = np.float32(path_y[0]), np.float32(path_y[1]), np.float32(path_y[2])
    start = np.uint64(col)
    k0, k1, k2, k3 = start + steps[0], start + steps[1], start + steps[2], start + steps[3]
    k4 = start + steps[4]
    c0, c1, c2 = coefficients[row], coefficients[row + 1], coefficients[row + 2]
    c3, c4 = coefficients[row + 3], coefficients[row + 4]
    for i in range(np.uint64(first), np.uint64(last)):
        x = lane_x[i]
        p0, p1, p2, p3, p4 = _weights_across(ax + x * (bx + ex * x))
        q0, q1, q2, q3, q4 = _weights_across(ay + x * (by + ey * x))
        k = k0 + i, k1 + i, k2 + i, k3 + i, k4 + i
        r0 = p0 * c0[k[0]] + p1 * c0[k[1]] + p2 * c0[k[2]] + p3 * c0[k[3]] + p4 * c0[k[4]]
        r1 = p0 * c1[k[0]] + p1 * c1[k[1]] + p2 * c1[k[2]] + p3 * c1[k[3]] + p4 * c1[k[4]]
        r2 = p0 * c2[k[0]] + p1 * c2[k[1]] + p2 * c2[k[2]] + p3 * c2[k[3]] + p4 * c2[k[4]]
        r3 = p0 * c3[k[0]] + p1 * c3[k[1]] + p2 * c3[k[2]] + p3 * c3[k[3]] + p4 * c3[k[4]]
        r4 = p0 * c4[k[0]] + p1 * c4[k[1]] + p2 * c4[k[2]] + p3 * c4[k[3]] + p4 * c4[k[4]]
        out[i] = q0 * r0 + q1 * r1 + q2 * r2 + q3 * r3 + q4 * r4


@njit(cache=True, error_model="numpy")
def _scattered(coefficients, row, col, path_x, path_y, lane_x, first, last, out):  # type: ignore[no-untyped-def]
    """Interpolate lanes one by one, each with a support of its own."""
    for i in range(first, last):
        x = np.float64(lane_x[i])
        tx = path_x[0] + x * (path_x[1] + path_x[2] * x)
        ty = path_y[0] + x * (path_y[1] + path_y[2] * x)
        jump_x, jump_y = int(np.floor(tx)), int(np.floor(ty))
        p = _weights(np.float32(tx - jump_x))
        q = _weights(np.float32(ty - jump_y))
        top, left = row + jump_y, col + i + jump_x
        total = _ZERO
        for j in range(4):
            line = coefficients[top + j]
            total += q[j] * (
                p[0] * line[left]
                + p[1] * line[left + 1]
                + p[2] * line[left + 2]
                + p[3] * line[left + 3]
            )
        out[i] = total


@njit(inline="always")
def _span(path, x0, x1):  # type: ignore[no-untyped-def]
    """Bounds of a quadratic path between two lanes."""
    at_start = path[0] + x0 * (path[1] + path[2] * x0)
    at_end = path[0] + x1 * (path[1] + path[2] * x1)
    bulge = 0.25 * path[2] * (x1 - x0) * (x1 - x0)
    return min(at_start, at_end) - max(bulge, 0.0), max(at_start, at_end) - min(bulge, 0.0)


@njit(cache=True, error_model="numpy")
def _run(coefficients, row, col, path_x, path_y, lane_x, steps, first, last, used, out):  # type: ignore[no-untyped-def]
    """Interpolate lanes first ... last - 1 in runs if they allow it; tell whether they did.

    Only the lanes before `used` have to be right.
    """
    x0, x1 = np.float64(lane_x[first]), np.float64(lane_x[min(last, used) - 1])
    low_x, high_x = _span(path_x, x0, x1)
    low_y, high_y = _span(path_y, x0, x1)
    jump_x, jump_y = np.floor(0.5 * (low_x + high_x)), np.floor(0.5 * (low_y + high_y))
    steady_x = low_x - jump_x >= -SLACK and high_x - jump_x <= 1.0 + SLACK
    steady_y = low_y - jump_y >= -SLACK and high_y - jump_y <= 1.0 + SLACK
    if not steady_x:
        jump_x = np.floor(low_x)
    if not steady_y:
        jump_y = np.floor(low_y)
    if high_x - jump_x >= 2.0 or high_y - jump_y >= 2.0:
        return False
    shifted_x = (path_x[0] - jump_x, path_x[1], path_x[2])
    shifted_y = (path_y[0] - jump_y, path_y[1], path_y[2])
    top, left = row + int(jump_y), col + int(jump_x)
    if steady_x and steady_y:
        _run_of_four(
            coefficients, top, left, shifted_x, shifted_y, lane_x, steps, first, last, out
        )
    else:
        _run_of_five(
            coefficients, top, left, shifted_x, shifted_y, lane_x, steps, first, last, out
        )
    return True


@njit(cache=True, error_model="numpy")
def interpolate_subset(
    coefficients: Greys,
    centre_x: int,
    centre_y: int,
    warp: Floats,
    radius: int,
    lane_x: Greys,
    steps: np.ndarray,  # type: ignore[type-arg]
    out: Greys,
) -> None:
    """Sample the deformed picture at the warped pixels of one subset.

    Parameters
    ----------
    coefficients : (H, W) float32
        Cubic B-spline coefficients. The caller makes sure that the warped subset stays at
        least 3 px, and `lanes - width` px more on the right, inside.
    centre_x, centre_y : int
        Centre of the subset, px.
    warp : (12,)
        x then y of the warped position relative to the centre, as coefficients of
        1, x, y, x^2, x y, y^2 in local px.
    radius : int
        Of the subset, px; its width is 2 radius + 1.
    lane_x : (L,) float32
        Local x of every lane, -radius in lane 0.
    steps : (5,) uint64
        0 ... 4.
    out : (2 radius + 1, L) float32
        Filled with grey levels; lanes beyond the width hold anything finite.
    """
    width = 2 * radius + 1
    lanes = lane_x.shape[0]
    for j in range(width):
        y = float(j - radius)
        path_x = (
            warp[0] + y * (warp[2] + warp[5] * y),
            warp[1] - 1.0 + warp[4] * y,
            warp[3],
        )
        path_y = (
            warp[6] + y * (warp[8] - 1.0 + warp[11] * y),
            warp[7] + warp[10] * y,
            warp[9],
        )
        row, col = centre_y + j - radius - 1, centre_x - radius - 1
        line = out[j]
        if _run(
            coefficients, row, col, path_x, path_y, lane_x, steps, 0, lanes, width, line
        ):
            continue
        for first in range(0, width, CHUNK):
            last = first + CHUNK
            if not _run(
                coefficients, row, col, path_x, path_y, lane_x, steps, first, last, width, line
            ):
                _scattered(
                    coefficients, row, col, path_x, path_y, lane_x, first, min(last, width), line
                )
