"""Interpolate a warped subset and sum it up, in one pass.

All that Gauss-Newton needs of a subset are its moments: sums of the deformed grey alone,
times the reference grey, and times the slopes with powers of x and y. x belongs to a
column and y to a row: sums are kept for every column, with the powers of y alone, and
the powers of x come in once at the end.

The subset is read in blocks of `LANES` columns, row by row. Near the identity the 4 x 4
spline supports of neighbouring pixels in a row are neighbours too, so a row of a block is
read as vectors from 16 places instead of being gathered pixel by pixel. A row in which the
support jumps once is read from 25 places, of which the weights switch sixteen on. What
fits neither is gathered. Columns beyond the subset have weight zero. A quintic spline has
supports of 6 x 6 and reads 36 and 49 places.
"""

import numpy as np

from shapemorph.kernels.inner import inner
from shapemorph.kernels.subset_taps import grey_gathered, grey_in_step, grey_with_jump, scale_of
from shapemorph.kernels.vectors import LANES, fused, load, spread, total

SLACK = 0.02  # how far a spline piece is used beyond its end: off by 1e-5 of the contrast
VECTOR_FLAGS = {"reassoc", "contract", "nsz", "arcp"}  # NaN and infinity keep their meaning


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
def common_jump(part, radius):  # type: ignore[no-untyped-def]
    """Like `_jump` for all rows together; `part` is one half of a warp less the identity."""
    reach = radius * (abs(part[1]) + abs(part[2]))
    reach += radius * radius * (abs(part[3]) + abs(part[4]) + abs(part[5]))
    jump = np.floor(part[0])
    offset = part[0] - jump
    return jump, offset - reach >= -SLACK and offset + reach <= 1.0 + SLACK


@inner(forceinline=True)
def paths(part, xs, second):  # type: ignore[no-untyped-def]
    """Motion of a block of columns as polynomials in y; `part` is half of a warp less identity."""
    path, slope = fused(xs, spread(part[1]), spread(part[0])), spread(part[2])
    if second is not None:
        path = fused(xs * xs, spread(part[3]), path)
        slope = fused(xs, spread(part[4]), slope)
    return path, slope, spread(part[5])


@inner(forceinline=True)
def path_at(path, slope, bend, y, second):  # type: ignore[no-untyped-def]
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


@inner(fastmath=VECTOR_FLAGS)
def warped_moments(  # type: ignore[no-untyped-def]
    c, wide, x, y, warp, radius, second, reference, weights, lane_x, mean, moments
):  # fmt: skip
    """Sum up the deformed picture over one warped subset.

    Parameters
    ----------
    c : (H, W) float32
        B-spline coefficients of the deformed picture. The caller makes sure that the warped
        subset stays inside by 4 px, and by LANES px more on the right.
    wide : None or int
        None for a cubic spline, any number for a quintic one.
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
    jump_x, alike_x = common_jump(ux, radius)
    jump_y, alike_y = common_jump(uy, radius)
    alike = alike_x and alike_y
    tap = int(jump_y) * stride + int(jump_x)
    scale, lift = spread(scale_of(wide)), spread(-mean)
    t0 = t1 = t2 = t3 = t4 = t5 = t6 = t7 = t8 = spread(0.0)
    t9 = t10 = t11 = t12 = t13 = t14 = spread(0.0)
    for first in range(0, lanes, LANES):
        xs = load(lane_x, first)
        x_path, x_slope, x_bend = paths(ux, xs, second)
        y_path, y_slope, y_bend = paths(uy, xs, second)
        at = (y - radius) * stride + x - radius + first
        sums = _no_sums()
        if alike:
            x_path, y_path = x_path - spread(jump_x), y_path - spread(jump_y)
            b = spread(float(-radius - 1))
            for j in range(width):
                b = b + spread(1.0)
                t = path_at(x_path, x_slope, x_bend, b, second)
                u = path_at(y_path, y_slope, y_bend, b, second)
                weight = load(weights, j * lanes + first)
                grey = fused(grey_in_step(c, stride, at + tap, t, u, wide), scale, lift) * weight
                sums = _add(sums, grey, b, reference, at, second)
                at += stride
        else:
            x0, x1 = float(first - radius), float(min(first + LANES - 1, width - 1) - radius)
            for j in range(width):
                b = float(j - radius)
                x_jump, supports_x = _jump(_row_path(ux, b), x0, x1)
                y_jump, supports_y = _jump(_row_path(uy, b), x0, x1)
                supports = max(supports_x, supports_y)
                t = path_at(x_path, x_slope, x_bend, spread(b), second) - spread(x_jump)
                u = path_at(y_path, y_slope, y_bend, spread(b), second) - spread(y_jump)
                weight = load(weights, j * lanes + first)
                tap = at + int(y_jump) * stride + int(x_jump)
                if supports == 1:
                    grey = grey_in_step(c, stride, tap, t, u, wide)
                elif supports == 2:
                    grey = grey_with_jump(c, stride, tap, t, u, wide)
                else:
                    grey = grey_gathered(c, stride, tap, t + xs - spread(x0), u, weight, wide)
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
