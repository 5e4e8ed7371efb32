"""What Gauss-Newton needs of the reference subset, once for each point.

The products of the slopes are summed over rows with powers of x and gathered with
powers of y: the Hessian of an affine subset takes nine sums a row, not twenty-one.
"""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats
from shapemorph.kernels.subset_rows import VECTOR_FLAGS

_ZERO = np.float32(0.0)


@njit(cache=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def mean_grey(reference, weights, row, col, count):  # type: ignore[no-untyped-def]
    """Mean of the reference grey over the pixels of a subset that count."""
    total = _ZERO
    lanes = np.uint64(weights.shape[1])
    start = np.uint64(col)
    for j in range(weights.shape[0]):
        line, near = np.uint64(row + j), np.uint64(j)
        for i in range(lanes):
            total += reference[0, line, start + i] * weights[near, i]
    return total / np.float32(count)


@njit(forceinline=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _slope_products(reference, weights, lane_x, line, near, start, lanes, second):  # type: ignore[no-untyped-def]
    """Sum the products of slopes times powers of x over a row."""
    a0 = a1 = a2 = a3 = a4 = _ZERO
    b0 = b1 = b2 = b3 = b4 = _ZERO
    c0 = c1 = c2 = c3 = c4 = _ZERO
    for i in range(lanes):
        x = lane_x[i]
        gx, gy = reference[1, line, start + i], reference[2, line, start + i]
        wx = gx * weights[near, i]
        a, b, c = wx * gx, wx * gy, gy * gy * weights[near, i]
        ax, bx, cx = a * x, b * x, c * x
        axx, bxx, cxx = ax * x, bx * x, cx * x
        a0, b0, c0 = a0 + a, b0 + b, c0 + c
        a1, b1, c1 = a1 + ax, b1 + bx, c1 + cx
        a2, b2, c2 = a2 + axx, b2 + bxx, c2 + cxx
        if second is not None:
            a3, b3, c3 = a3 + axx * x, b3 + bxx * x, c3 + cxx * x
            a4, b4, c4 = a4 + axx * x * x, b4 + bxx * x * x, c4 + cxx * x * x
    return (a0, a1, a2, a3, a4), (b0, b1, b2, b3, b4), (c0, c1, c2, c3, c4)


@njit(forceinline=True, fastmath=VECTOR_FLAGS, error_model="numpy")
def _slope_sums(reference, weights, lane_x, line, near, start, lanes, mean, second):  # type: ignore[no-untyped-def]
    """Sum grey, and slopes and grey times slopes with powers of x, over a row."""
    f0 = f1 = a0 = a1 = a2 = b0 = b1 = b2 = _ZERO
    c0 = c1 = c2 = d0 = d1 = d2 = _ZERO
    for i in range(lanes):
        x, w = lane_x[i], weights[near, i]
        f = (reference[0, line, start + i] - mean) * w
        a, b = reference[1, line, start + i] * w, reference[2, line, start + i] * w
        c, d = f * a, f * b
        ax, bx, cx, dx = a * x, b * x, c * x, d * x
        f0, f1 = f0 + f, f1 + f * f
        a0, b0, c0, d0 = a0 + a, b0 + b, c0 + c, d0 + d
        a1, b1, c1, d1 = a1 + ax, b1 + bx, c1 + cx, d1 + dx
        if second is not None:
            a2, b2, c2, d2 = a2 + ax * x, b2 + bx * x, c2 + cx * x, d2 + dx * x
    return (f0, f1), (a0, a1, a2), (b0, b1, b2), (c0, c1, c2), (d0, d1, d2)


@njit(forceinline=True, error_model="numpy")
def _spread_products(row_sums, y, degree, out):  # type: ignore[no-untyped-def]
    """Add the sums of a row, times powers of y, to the moments x^a y^b, a + b <= degree."""
    power = 1.0
    for b in range(degree + 1):
        for a in range(degree + 1 - b):
            out[(a + b) * (a + b + 1) // 2 + b] += row_sums[a] * power
        power *= y


@njit(forceinline=True, error_model="numpy")
def _spread_sums(sums, y, out, first, second):  # type: ignore[no-untyped-def]
    """Add the sums of a row to the moments of 1, x, y, x^2, x y, y^2 from `first` on."""
    out[first] += sums[0]
    out[first + 1] += sums[1]
    out[first + 2] += sums[0] * y
    if second is not None:
        out[first + 3] += sums[2]
        out[first + 4] += sums[1] * y
        out[first + 5] += sums[0] * y * y


@njit(cache=True, error_model="numpy")
def reference_moments(  # type: ignore[no-untyped-def]
    reference, weights, lane_x, row, col, mean, second, products, total, along
):  # fmt: skip
    """Sum up one subset of the reference.

    Parameters
    ----------
    reference : (3, H, W) float32
        Grey, slope along x, slope along y.
    weights : (R, L) float32
        1 for pixels that count, else 0.
    lane_x : (L,) float32
        Local x of the lanes.
    row, col : int
        Of the upper left pixel of the subset.
    mean : float32
        Taken off the grey.
    second : None or int
        None leaves out what only second order needs.
    products : (3, 15)
        Filled with the sums of slope x slope (xx, xy, yy) times x^a y^b; a + b = n stand
        from n (n + 1) / 2 on, in the order of b.
    total, along : (15,)
        Filled like the moments of a warped subset, for a grey of one and for the
        reference grey itself; along[0:2] are the sums of grey and its square.
    """
    products[:] = 0.0
    total[:] = 0.0
    along[:] = 0.0
    lanes, start = np.uint64(weights.shape[1]), np.uint64(col)
    degree = 2 if second is None else 4
    for j in range(weights.shape[0]):
        y = float(lane_x[j])
        line, near = np.uint64(row + j), np.uint64(j)
        xx, xy, yy = _slope_products(reference, weights, lane_x, line, near, start, lanes, second)
        _spread_products(xx, y, degree, products[0])
        _spread_products(xy, y, degree, products[1])
        _spread_products(yy, y, degree, products[2])
        grey, along_x, along_y, grey_x, grey_y = _slope_sums(
            reference, weights, lane_x, line, near, start, lanes, mean, second
        )
        along[0] += grey[0]
        along[1] += grey[1]
        _spread_sums(along_x, y, total, 3, second)
        _spread_sums(along_y, y, total, 9, second)
        _spread_sums(grey_x, y, along, 3, second)
        _spread_sums(grey_y, y, along, 9, second)


@njit(cache=True, error_model="numpy")
def fill_hessian(  # type: ignore[no-untyped-def]
    products: Floats, total: Floats, along: Floats, count, energy, terms, hessian
) -> None:
    """Hessian of the normalised residual from the moments of the reference.

    What gain and offset of the grey can explain is taken out. Rows are the terms along x,
    then those along y; only the lower triangle is filled.
    """
    for a in range(2 * terms):
        half_a, s = a // terms, a % terms
        degree_s = 0 if s == 0 else (1 if s < 3 else 2)
        power_s = s - degree_s * (degree_s + 1) // 2
        at_a = 3 + 6 * half_a + s
        for b in range(a + 1):
            half_b, t = b // terms, b % terms
            degree_t = 0 if t == 0 else (1 if t < 3 else 2)
            power_t = t - degree_t * (degree_t + 1) // 2
            at_b = 3 + 6 * half_b + t
            degree = degree_s + degree_t
            place = degree * (degree + 1) // 2 + power_s + power_t
            hessian[a, b] = (
                products[half_a + half_b, place]
                - total[at_a] * total[at_b] / count
                - along[at_a] * along[at_b] / energy
            )
