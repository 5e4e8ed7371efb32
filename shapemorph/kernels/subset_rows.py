"""Interpolate the rows of a warped subset and sum them up, in one pass.

All that Gauss-Newton needs of a row are its moments: sums of the deformed grey alone,
times the reference grey, and times the slopes with powers of x. y is constant along a
row, so its powers come in later.

Near the identity the 4 x 4 spline supports of neighbouring pixels in a row are
neighbours too, so a row is read as contiguous runs instead of being gathered pixel by
pixel. A run in which the support jumps once is read with five columns and rows, of
which the weights switch four on. A row that fits neither is cut into short runs, and
what fits nothing is gathered.

Rows are read in whole vectors of `LANES` pixels; the pixels beyond the subset have
weight zero. To keep the loops in vector registers, indices are unsigned (a signed one
brings a test for negative positions), constants are typed (a plain literal turns all
into float64), nothing is stored inside a loop, and the offsets of the taps come from an
array (with literal offsets the compiler shuffles the loads of the pixel before, which
is slower than loading again).
"""

import numpy as np
from numba import njit

LANES = 8
SLACK = 0.02  # how far a spline piece is used beyond its end: off by 1e-5 of the contrast
VECTOR_FLAGS = {"reassoc", "contract", "nsz", "arcp"}  # NaN and infinity keep their meaning

_ZERO = np.float32(0.0)
_ONE = np.float32(1.0)
_TWO = np.float32(2.0)
_HALF = np.float32(0.5)
_SIXTH = np.float32(1.0 / 6.0)
_TWO_THIRDS = np.float32(2.0 / 3.0)


@njit(forceinline=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _weights(t):  # type: ignore[no-untyped-def]
    """Weights of the four knots around offset t, in float32."""
    s = _ONE - t
    left = _TWO_THIRDS - _HALF * t * t * (_TWO - t)
    right = _TWO_THIRDS - _HALF * s * s * (_TWO - s)
    return s * s * s * _SIXTH, left, right, t * t * t * _SIXTH


@njit(forceinline=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _weights_across(t):  # type: ignore[no-untyped-def]
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


@njit(forceinline=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _add(s0, s1, s2, s3, s4, s5, s6, s7, s8, value, x, pattern, slope_x, slope_y, second):  # type: ignore[no-untyped-def]
    """Add one pixel to the moments of a row; `second` None leaves the squares of x out."""
    along_x, along_y = slope_x * value, slope_y * value
    x1, y1 = along_x * x, along_y * x
    s0 += value
    s1 += value * value
    s2 += pattern * value
    s3 += along_x
    s4 += x1
    s5 += along_y
    s6 += y1
    if second is not None:
        s7 += x1 * x
        s8 += y1 * x
    return s0, s1, s2, s3, s4, s5, s6, s7, s8


@njit(forceinline=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _run_of_four(  # type: ignore[no-untyped-def]
    c, row, col, px, py, second,
    reference, weights, lane_x, steps, line, near, origin, first, last, mean,
):  # fmt: skip
    """Moments of pixels whose supports advance by one column each."""
    ax, bx, ex = np.float32(px[0]), np.float32(px[1]), np.float32(px[2])
    ay, by, ey = np.float32(py[0]), np.float32(py[1]), np.float32(py[2])
    r0 = np.uint64(row)
    r1, r2, r3 = r0 + steps[1], r0 + steps[2], r0 + steps[3]
    start = np.uint64(col)
    k0, k1, k2, k3 = start + steps[0], start + steps[1], start + steps[2], start + steps[3]
    s0 = s1 = s2 = s3 = s4 = s5 = s6 = s7 = s8 = _ZERO
    for i in range(np.uint64(first), np.uint64(last)):
        x = lane_x[i]
        p0, p1, p2, p3 = _weights(ax + x * (bx + ex * x))
        q0, q1, q2, q3 = _weights(ay + x * (by + ey * x))
        value = (
            q0 * (p0 * c[r0, k0 + i] + p1 * c[r0, k1 + i] + p2 * c[r0, k2 + i] + p3 * c[r0, k3 + i])
            + q1
            * (p0 * c[r1, k0 + i] + p1 * c[r1, k1 + i] + p2 * c[r1, k2 + i] + p3 * c[r1, k3 + i])
            + q2
            * (p0 * c[r2, k0 + i] + p1 * c[r2, k1 + i] + p2 * c[r2, k2 + i] + p3 * c[r2, k3 + i])
            + q3
            * (p0 * c[r3, k0 + i] + p1 * c[r3, k1 + i] + p2 * c[r3, k2 + i] + p3 * c[r3, k3 + i])
        )
        at = origin + i
        value = (value - mean) * weights[near, i]
        s0, s1, s2, s3, s4, s5, s6, s7, s8 = _add(
            s0, s1, s2, s3, s4, s5, s6, s7, s8,
            value, x, reference[0, line, at], reference[1, line, at], reference[2, line, at],
            second,
        )  # fmt: skip
    return s0, s1, s2, s3, s4, s5, s6, s7, s8


@njit(forceinline=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _run_of_five(  # type: ignore[no-untyped-def]
    c, row, col, px, py, second,
    reference, weights, lane_x, steps, line, near, origin, first, last, mean,
):  # fmt: skip
    """Moments of pixels whose supports jump by one column or row at most once."""
    ax, bx, ex = np.float32(px[0]), np.float32(px[1]), np.float32(px[2])
    ay, by, ey = np.float32(py[0]), np.float32(py[1]), np.float32(py[2])
    r0 = np.uint64(row)
    r1, r2, r3, r4 = r0 + steps[1], r0 + steps[2], r0 + steps[3], r0 + steps[4]
    start = np.uint64(col)
    k0, k1, k2, k3 = start + steps[0], start + steps[1], start + steps[2], start + steps[3]
    k4 = start + steps[4]
    s0 = s1 = s2 = s3 = s4 = s5 = s6 = s7 = s8 = _ZERO
    for i in range(np.uint64(first), np.uint64(last)):
        x = lane_x[i]
        p0, p1, p2, p3, p4 = _weights_across(ax + x * (bx + ex * x))
        q0, q1, q2, q3, q4 = _weights_across(ay + x * (by + ey * x))
        a, b, d, e, f = k0 + i, k1 + i, k2 + i, k3 + i, k4 + i
        value = (
            q0 * (p0 * c[r0, a] + p1 * c[r0, b] + p2 * c[r0, d] + p3 * c[r0, e] + p4 * c[r0, f])
            + q1 * (p0 * c[r1, a] + p1 * c[r1, b] + p2 * c[r1, d] + p3 * c[r1, e] + p4 * c[r1, f])
            + q2 * (p0 * c[r2, a] + p1 * c[r2, b] + p2 * c[r2, d] + p3 * c[r2, e] + p4 * c[r2, f])
            + q3 * (p0 * c[r3, a] + p1 * c[r3, b] + p2 * c[r3, d] + p3 * c[r3, e] + p4 * c[r3, f])
            + q4 * (p0 * c[r4, a] + p1 * c[r4, b] + p2 * c[r4, d] + p3 * c[r4, e] + p4 * c[r4, f])
        )
        at = origin + i
        value = (value - mean) * weights[near, i]
        s0, s1, s2, s3, s4, s5, s6, s7, s8 = _add(
            s0, s1, s2, s3, s4, s5, s6, s7, s8,
            value, x, reference[0, line, at], reference[1, line, at], reference[2, line, at],
            second,
        )  # fmt: skip
    return s0, s1, s2, s3, s4, s5, s6, s7, s8


@njit(cache=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _gathered(  # type: ignore[no-untyped-def]
    c, row, col, px, py, second,
    reference, weights, lane_x, line, near, origin, first, last, mean,
):  # fmt: skip
    """Moments of pixels that each have a support of their own."""
    s0 = s1 = s2 = s3 = s4 = s5 = s6 = s7 = s8 = _ZERO
    for i in range(first, last):
        if weights[near, i] == _ZERO:
            continue
        x = lane_x[i]
        at_x = px[0] + x * (px[1] + px[2] * x)
        at_y = py[0] + x * (py[1] + py[2] * x)
        jump_x, jump_y = int(np.floor(at_x)), int(np.floor(at_y))
        p0, p1, p2, p3 = _weights(np.float32(at_x - jump_x))
        q0, q1, q2, q3 = _weights(np.float32(at_y - jump_y))
        top, k = row + jump_y, col + i + jump_x
        value = (
            q0 * (p0 * c[top, k] + p1 * c[top, k + 1] + p2 * c[top, k + 2] + p3 * c[top, k + 3])
            + q1
            * (
                p0 * c[top + 1, k]
                + p1 * c[top + 1, k + 1]
                + p2 * c[top + 1, k + 2]
                + p3 * c[top + 1, k + 3]
            )
            + q2
            * (
                p0 * c[top + 2, k]
                + p1 * c[top + 2, k + 1]
                + p2 * c[top + 2, k + 2]
                + p3 * c[top + 2, k + 3]
            )
            + q3
            * (
                p0 * c[top + 3, k]
                + p1 * c[top + 3, k + 1]
                + p2 * c[top + 3, k + 2]
                + p3 * c[top + 3, k + 3]
            )
        )
        at = int(origin) + i
        value = (value - mean) * weights[near, i]
        s0, s1, s2, s3, s4, s5, s6, s7, s8 = _add(
            s0, s1, s2, s3, s4, s5, s6, s7, s8,
            value, x, reference[0, line, at], reference[1, line, at], reference[2, line, at],
            second,
        )  # fmt: skip
    return s0, s1, s2, s3, s4, s5, s6, s7, s8


@njit(forceinline=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _jump(path, x0, x1):  # type: ignore[no-untyped-def]
    """Whole pixels to take off a quadratic path, and the number of supports it then needs."""
    start = path[0] + x0 * (path[1] + path[2] * x0)
    end = path[0] + x1 * (path[1] + path[2] * x1)
    bulge = 0.25 * path[2] * (x1 - x0) * (x1 - x0)
    low = (start if start < end else end) - (bulge if bulge > 0.0 else 0.0)
    high = (end if start < end else start) - (0.0 if bulge > 0.0 else bulge)
    middle = np.floor(0.5 * (low + high))
    if low - middle >= -SLACK and high - middle <= 1.0 + SLACK:
        return middle, 1
    first = np.floor(low)
    return first, (2 if high - first < 2.0 else 3)


@njit(forceinline=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _common_jump(part, radius):  # type: ignore[no-untyped-def]
    """Like `_jump` for all rows together; `part` is one half of a warp less the identity."""
    reach = radius * (abs(part[1]) + abs(part[2]))
    reach += radius * radius * (abs(part[3]) + abs(part[4]) + abs(part[5]))
    jump = np.floor(part[0])
    offset = part[0] - jump
    return jump, offset - reach >= -SLACK and offset + reach <= 1.0 + SLACK


@njit(cache=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _row_in_pieces(  # type: ignore[no-untyped-def]
    c, row, col, px, py, second, width,
    reference, weights, lane_x, steps, line, near, origin, mean,
):  # fmt: skip
    """Moments of a row of which the supports jump often: short runs, else gathered."""
    t0 = t1 = t2 = t3 = t4 = t5 = t6 = t7 = t8 = _ZERO
    for first in range(0, width, LANES):
        last = first + LANES
        x0, x1 = np.float64(lane_x[first]), np.float64(lane_x[min(last, width) - 1])
        jump_x, supports_x = _jump(px, x0, x1)
        jump_y, supports_y = _jump(py, x0, x1)
        if max(supports_x, supports_y) <= 2:
            s0, s1, s2, s3, s4, s5, s6, s7, s8 = _run_of_five(
                c, row + int(jump_y), col + int(jump_x),
                (px[0] - jump_x, px[1], px[2]), (py[0] - jump_y, py[1], py[2]), second,
                reference, weights, lane_x, steps, line, near, origin, first, last, mean,
            )  # fmt: skip
        else:
            s0, s1, s2, s3, s4, s5, s6, s7, s8 = _gathered(
                c, row, col, px, py, second,
                reference, weights, lane_x, line, near, origin, first, last, mean,
            )  # fmt: skip
        t0, t1, t2, t3, t4 = t0 + s0, t1 + s1, t2 + s2, t3 + s3, t4 + s4
        t5, t6, t7, t8 = t5 + s5, t6 + s6, t7 + s7, t8 + s8
    return t0, t1, t2, t3, t4, t5, t6, t7, t8


@njit(cache=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def warped_moments(  # type: ignore[no-untyped-def]
    c, x, y, warp, radius, second, reference, weights, lane_x, steps, mean, moments
):  # fmt: skip
    """Sum up the deformed picture over one warped subset.

    Parameters
    ----------
    c : (H, W) float32
        Cubic B-spline coefficients of the deformed picture. The caller makes sure that
        the warped subset stays inside by 3 px, and by 8 px more on the right.
    x, y : int
        Centre of the subset, px.
    warp : (12,)
        Warped position relative to the centre, x then y, as coefficients of 1, x, y,
        x^2, x y, y^2 in local px.
    radius : int
        The subset is 2 radius + 1 px wide.
    second : None or int
        None leaves the moments of second degree out.
    reference : (3, H, W) float32
        Grey, slope along x, slope along y.
    weights : (2 radius + 1, L) float32
        1 for pixels that count, else 0; L is a multiple of LANES.
    lane_x : (L,) float32
        Local x of the lanes, -radius first.
    steps : (5,) uint64
        0 ... 4.
    mean : float32
        Taken off the deformed grey before it is summed.
    moments : (15,)
        Filled with the sums of the deformed grey g: g, g^2, g times the reference grey;
        g times the slope along x times 1, x, y, x^2, x y, y^2; the same along y.
    """
    width, lanes = weights.shape
    x0, x1 = -float(radius), float(radius)
    row, col = y - radius - 1, x - radius - 1
    origin = np.uint64(x - radius)
    ux = warp[0], warp[1] - 1.0, warp[2], warp[3], warp[4], warp[5]
    uy = warp[6], warp[7], warp[8] - 1.0, warp[9], warp[10], warp[11]
    jump_x, alike_x = _common_jump(ux, x1)
    jump_y, alike_y = _common_jump(uy, x1)
    supports_x = supports_y = 1
    m0 = m1 = m2 = m3 = m4 = m5 = m6 = m7 = m8 = m9 = m10 = m11 = m12 = m13 = m14 = 0.0
    for j in range(width):
        b = float(j - radius)
        px = ux[0] + b * (ux[2] + ux[5] * b), ux[1] + ux[4] * b, ux[3]
        py = uy[0] + b * (uy[2] + uy[5] * b), uy[1] + uy[4] * b, uy[3]
        if not (alike_x and alike_y):
            jump_x, supports_x = _jump(px, x0, x1)
            jump_y, supports_y = _jump(py, x0, x1)
        top, left = row + j + int(jump_y), col + int(jump_x)
        qx, qy = (px[0] - jump_x, px[1], px[2]), (py[0] - jump_y, py[1], py[2])
        line, near = np.uint64(y + j - radius), np.uint64(j)
        if supports_x + supports_y == 2:
            s0, s1, s2, s3, s4, s5, s6, s7, s8 = _run_of_four(
                c, top, left, qx, qy, second,
                reference, weights, lane_x, steps, line, near, origin, 0, lanes, mean,
            )  # fmt: skip
        elif supports_x < 3 and supports_y < 3:
            s0, s1, s2, s3, s4, s5, s6, s7, s8 = _run_of_five(
                c, top, left, qx, qy, second,
                reference, weights, lane_x, steps, line, near, origin, 0, lanes, mean,
            )  # fmt: skip
        else:
            s0, s1, s2, s3, s4, s5, s6, s7, s8 = _row_in_pieces(
                c, row + j, col, px, py, second, width,
                reference, weights, lane_x, steps, line, near, origin, mean,
            )  # fmt: skip
        m0, m1, m2, m3, m4, m5 = m0 + s0, m1 + s1, m2 + s2, m3 + s3, m4 + s4, m5 + s3 * b
        m9, m10, m11 = m9 + s5, m10 + s6, m11 + s5 * b
        if second is not None:
            m6, m7, m8 = m6 + s7, m7 + s4 * b, m8 + s3 * b * b
            m12, m13, m14 = m12 + s8, m13 + s6 * b, m14 + s5 * b * b
    moments[0], moments[1], moments[2], moments[3], moments[4] = m0, m1, m2, m3, m4
    moments[5], moments[6], moments[7], moments[8], moments[9] = m5, m6, m7, m8, m9
    moments[10], moments[11], moments[12], moments[13], moments[14] = m10, m11, m12, m13, m14
