"""Interpolate a warped subset and sum it up, in one pass.

All that Gauss-Newton needs of a subset are its moments: sums of the deformed grey alone,
times the reference grey, and times the slopes with powers of x and y. x belongs to a
column and y to a row: sums are kept for every column, with the powers of y alone, and
the powers of x come in once at the end.

The subset is read in blocks of `LANES` columns, row by row. Near the identity the 4 x 4
spline supports of neighbouring pixels in a row are neighbours too, so a row of a block is
read as vectors from 16 places instead of being gathered pixel by pixel. A row in which the
support jumps once is read from 25 places, of which the weights switch sixteen on. What
fits neither is gathered. Columns beyond the subset have weight zero.
"""

import numpy as np
from numba import njit

from shapemorph.kernels.inner import inner
from shapemorph.kernels.vectors import LANES, choose, fused, gather, load, spread, total, whole

SLACK = 0.02  # how far a spline piece is used beyond its end: off by 1e-5 of the contrast
VECTOR_FLAGS = {"reassoc", "contract", "nsz", "arcp"}  # NaN and infinity keep their meaning

_SCALE = 1.0 / 36.0  # the weights below are six times too large, in both directions


@inner(forceinline=True)
def _weights(t):  # type: ignore[no-untyped-def]
    """Weights of the four knots around offset t, times six."""
    s = spread(1.0) - t
    tt, ss = t * t, s * s
    left = fused(tt, fused(t, spread(3.0), spread(-6.0)), spread(4.0))
    right = fused(ss, fused(s, spread(3.0), spread(-6.0)), spread(4.0))
    return ss * s, left, right, tt * t


@inner(forceinline=True)
def _weights_across(t):  # type: ignore[no-untyped-def]
    """Weights of five knots for an offset t in [0, 2), times six."""
    zero, one = spread(0.0), spread(1.0)
    a, b, c, d = _weights(choose(t, one, t - one, t))
    return (
        choose(t, one, zero, a),
        choose(t, one, a, b),
        choose(t, one, b, c),
        choose(t, one, c, d),
        choose(t, one, d, zero),
    )


@inner(forceinline=True)
def _along_four(c, at, p0, p1, p2, p3):  # type: ignore[no-untyped-def]
    """Weighted sum of four neighbours in a row."""
    left = fused(p1, load(c, at + 1), p0 * load(c, at))
    return left + fused(p3, load(c, at + 3), p2 * load(c, at + 2))


@inner(forceinline=True)
def _four(c, stride, at, t, u):  # type: ignore[no-untyped-def]
    """Grey of pixels whose supports advance by one column each."""
    p0, p1, p2, p3 = _weights(t)
    q0, q1, q2, q3 = _weights(u)
    upper = q0 * _along_four(c, at, p0, p1, p2, p3)
    upper = fused(q1, _along_four(c, at + stride, p0, p1, p2, p3), upper)
    lower = q2 * _along_four(c, at + 2 * stride, p0, p1, p2, p3)
    return upper + fused(q3, _along_four(c, at + 3 * stride, p0, p1, p2, p3), lower)


@inner(forceinline=True)
def _along_five(c, at, p0, p1, p2, p3, p4):  # type: ignore[no-untyped-def]
    """Weighted sum of five neighbours in a row."""
    return fused(p4, load(c, at + 4), _along_four(c, at, p0, p1, p2, p3))


@inner(forceinline=True)
def _five(c, stride, at, t, u):  # type: ignore[no-untyped-def]
    """Grey of pixels whose supports jump by one column or row at most once."""
    p0, p1, p2, p3, p4 = _weights_across(t)
    q0, q1, q2, q3, q4 = _weights_across(u)
    grey = q0 * _along_five(c, at, p0, p1, p2, p3, p4)
    grey = fused(q1, _along_five(c, at + stride, p0, p1, p2, p3, p4), grey)
    grey = fused(q2, _along_five(c, at + 2 * stride, p0, p1, p2, p3, p4), grey)
    grey = fused(q3, _along_five(c, at + 3 * stride, p0, p1, p2, p3, p4), grey)
    return fused(q4, _along_five(c, at + 4 * stride, p0, p1, p2, p3, p4), grey)


@inner(forceinline=True)
def _gather_four(c, stride, at, row, col, used, p0, p1, p2, p3):  # type: ignore[no-untyped-def]
    sum_ = p0 * gather(c, at, stride, row, col, used)
    sum_ = fused(p1, gather(c, at + 1, stride, row, col, used), sum_)
    sum_ = fused(p2, gather(c, at + 2, stride, row, col, used), sum_)
    return fused(p3, gather(c, at + 3, stride, row, col, used), sum_)


@inner()
def _gathered(c, stride, at, x, y, used):  # type: ignore[no-untyped-def]
    """Grey of pixels that each have a support of their own."""
    col, row = whole(x), whole(y)
    p0, p1, p2, p3 = _weights(x - col)
    q0, q1, q2, q3 = _weights(y - row)
    grey = q0 * _gather_four(c, stride, at, row, col, used, p0, p1, p2, p3)
    grey = fused(q1, _gather_four(c, stride, at + stride, row, col, used, p0, p1, p2, p3), grey)
    grey = fused(q2, _gather_four(c, stride, at + 2 * stride, row, col, used, p0, p1, p2, p3), grey)
    return fused(q3, _gather_four(c, stride, at + 3 * stride, row, col, used, p0, p1, p2, p3), grey)


@inner(forceinline=True)
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


@inner(forceinline=True)
def _common_jump(part, radius):  # type: ignore[no-untyped-def]
    """Like `_jump` for all rows together; `part` is one half of a warp less the identity."""
    reach = radius * (abs(part[1]) + abs(part[2]))
    reach += radius * radius * (abs(part[3]) + abs(part[4]) + abs(part[5]))
    jump = np.floor(part[0])
    offset = part[0] - jump
    return jump, offset - reach >= -SLACK and offset + reach <= 1.0 + SLACK


@inner(forceinline=True)
def _paths(part, xs, second):  # type: ignore[no-untyped-def]
    """Motion of a block of columns as polynomials in y; `part` is half of a warp less identity."""
    path, slope = fused(xs, spread(part[1]), spread(part[0])), spread(part[2])
    if second is not None:
        path = fused(xs * xs, spread(part[3]), path)
        slope = fused(xs, spread(part[4]), slope)
    return path, slope, spread(part[5])


@inner(forceinline=True)
def _path_at(path, slope, bend, y, second):  # type: ignore[no-untyped-def]
    """Motion of a block of columns in one row."""
    if second is not None:
        slope = fused(bend, y, slope)
    return fused(slope, y, path)


@inner(forceinline=True)
def _row_path(part, y):  # type: ignore[no-untyped-def]
    """Motion of a row as a polynomial in x."""
    return part[0] + y * (part[2] + part[5] * y), part[1] + part[4] * y, part[3]


@inner(forceinline=True)
def _no_sums():  # type: ignore[no-untyped-def]
    zero = spread(0.0)
    return zero, zero, zero, zero, zero, zero, zero, zero, zero


@inner(forceinline=True)
def _add(sums, grey, y, reference, at, second):  # type: ignore[no-untyped-def]
    """Add a row to the sums of its columns; `second` None leaves the squares of y out."""
    s0, s1, s2, s3, s4, s5, s6, s7, s8 = sums
    plane = reference.shape[1] * reference.shape[2]
    slope_x, slope_y = load(reference, at + plane), load(reference, at + 2 * plane)
    s0, s1, s2 = s0 + grey, fused(grey, grey, s1), fused(grey, load(reference, at), s2)
    s3, s4 = fused(grey, slope_x, s3), fused(grey, slope_y, s4)
    grey = grey * y
    s5, s6 = fused(grey, slope_x, s5), fused(grey, slope_y, s6)
    if second is not None:
        grey = grey * y
        s7, s8 = fused(grey, slope_x, s7), fused(grey, slope_y, s8)
    return s0, s1, s2, s3, s4, s5, s6, s7, s8


@njit(cache=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def warped_moments(  # type: ignore[no-untyped-def]
    c, x, y, warp, radius, second, reference, weights, lane_x, mean, moments
):  # fmt: skip
    """Sum up the deformed picture over one warped subset.

    Parameters
    ----------
    c : (H, W) float32
        Cubic B-spline coefficients of the deformed picture. The caller makes sure that
        the warped subset stays inside by 3 px, and by LANES px more on the right.
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
        Local x of the columns, -radius first.
    mean : float32
        Taken off the deformed grey before it is summed.
    moments : (15,)
        Filled with the sums of the deformed grey g: g, g^2, g times the reference grey;
        g times the slope along x times 1, x, y, x^2, x y, y^2; the same along y.
    """
    width, lanes = weights.shape
    stride = c.shape[1]
    ux = warp[0], warp[1] - 1.0, warp[2], warp[3], warp[4], warp[5]
    uy = warp[6], warp[7], warp[8] - 1.0, warp[9], warp[10], warp[11]
    jump_x, alike_x = _common_jump(ux, radius)
    jump_y, alike_y = _common_jump(uy, radius)
    alike = alike_x and alike_y
    tap = (int(jump_y) - 1) * stride + int(jump_x) - 1
    scale, lift = spread(_SCALE), spread(-mean)
    t0 = t1 = t2 = t3 = t4 = t5 = t6 = t7 = t8 = spread(0.0)
    t9 = t10 = t11 = t12 = t13 = t14 = spread(0.0)
    for first in range(0, lanes, LANES):
        xs = load(lane_x, first)
        x_path, x_slope, x_bend = _paths(ux, xs, second)
        y_path, y_slope, y_bend = _paths(uy, xs, second)
        at = (y - radius) * stride + x - radius + first
        sums = _no_sums()
        if alike:
            x_path, y_path = x_path - spread(jump_x), y_path - spread(jump_y)
            b = spread(float(-radius - 1))
            for j in range(width):
                b = b + spread(1.0)
                t = _path_at(x_path, x_slope, x_bend, b, second)
                u = _path_at(y_path, y_slope, y_bend, b, second)
                weight = load(weights, j * lanes + first)
                grey = fused(_four(c, stride, at + tap, t, u), scale, lift) * weight
                sums = _add(sums, grey, b, reference, at, second)
                at += stride
        else:
            x0, x1 = float(first - radius), float(min(first + LANES - 1, width - 1) - radius)
            for j in range(width):
                b = float(j - radius)
                x_jump, supports_x = _jump(_row_path(ux, b), x0, x1)
                y_jump, supports_y = _jump(_row_path(uy, b), x0, x1)
                supports = max(supports_x, supports_y)
                t = _path_at(x_path, x_slope, x_bend, spread(b), second) - spread(x_jump)
                u = _path_at(y_path, y_slope, y_bend, spread(b), second) - spread(y_jump)
                weight = load(weights, j * lanes + first)
                tap = at + (int(y_jump) - 1) * stride + int(x_jump) - 1
                if supports == 1:
                    grey = _four(c, stride, tap, t, u)
                elif supports == 2:
                    grey = _five(c, stride, tap, t, u)
                else:
                    grey = _gathered(c, stride, tap, t + xs - spread(x0), u, weight)
                grey = fused(grey, scale, lift) * weight
                sums = _add(sums, grey, spread(b), reference, at, second)
                at += stride
        s0, s1, s2, s3, s4, s5, s6, s7, s8 = sums
        t0, t1, t2 = t0 + s0, t1 + s1, t2 + s2
        t3, t4, t5 = t3 + s3, fused(xs, s3, t4), t5 + s5
        t9, t10, t11 = t9 + s4, fused(xs, s4, t10), t11 + s6
        if second is not None:
            t6, t7, t8 = fused(xs * xs, s3, t6), fused(xs, s5, t7), t8 + s7
            t12, t13, t14 = fused(xs * xs, s4, t12), fused(xs, s6, t13), t14 + s8
    moments[0], moments[1], moments[2] = total(t0), total(t1), total(t2)
    moments[3], moments[4], moments[5] = total(t3), total(t4), total(t5)
    moments[9], moments[10], moments[11] = total(t9), total(t10), total(t11)
    if second is not None:
        moments[6], moments[7], moments[8] = total(t6), total(t7), total(t8)
        moments[12], moments[13], moments[14] = total(t12), total(t13), total(t14)
