"""What Gauss-Newton needs of the reference subset, once for each point.

The products of the slopes are summed for every column with powers of y; the powers of x
come in once at the end.
"""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.kernels.inner import inner
from shapemorph.kernels.small_linear import clear
from shapemorph.kernels.subset_rows import VECTOR_FLAGS
from shapemorph.kernels.vectors import LANES, fused, load, spread, total

# place of the product of two of the terms 1, x, y, x^2, x y, y^2 among the moments x^a y^b
_PRODUCT = np.array(
    [
        [0, 1, 2, 3, 4, 5],
        [1, 3, 4, 6, 7, 8],
        [2, 4, 5, 7, 8, 9],
        [3, 6, 7, 10, 11, 12],
        [4, 7, 8, 11, 12, 13],
        [5, 8, 9, 12, 13, 14],
    ]
)


@inner(fastmath=VECTOR_FLAGS)
def mean_grey(reference, weights, row, col, count):  # type: ignore[no-untyped-def]
    """Mean of the reference grey over the pixels of a subset that count."""
    width, lanes = weights.shape
    stride = reference.shape[2]
    sum_ = spread(0.0)
    for j in range(width):
        at = (row + j) * stride + col
        for first in range(0, lanes, LANES):
            sum_ = fused(load(reference, at + first), load(weights, j * lanes + first), sum_)
    return np.float32(total(sum_) / count)


@inner(forceinline=True)
def _columns_of_products(reference, at, weights, lanes, first, radius):  # type: ignore[no-untyped-def]
    """Products of the slopes, times 1, y, y^2, summed over the rows of a block of columns."""
    a0 = a1 = a2 = b0 = b1 = b2 = c0 = c1 = c2 = spread(0.0)
    stride = reference.shape[2]
    plane = reference.shape[1] * stride
    for j in range(weights.shape[0]):
        y = spread(float(j - radius))
        slope_x = load(reference, at + j * stride + plane)
        slope_y = load(reference, at + j * stride + 2 * plane)
        weight = load(weights, j * lanes + first)
        wx = slope_x * weight
        a, b, c = wx * slope_x, wx * slope_y, slope_y * slope_y * weight
        a0, b0, c0 = a0 + a, b0 + b, c0 + c
        a, b, c = a * y, b * y, c * y
        a1, b1, c1 = a1 + a, b1 + b, c1 + c
        a2, b2, c2 = fused(a, y, a2), fused(b, y, b2), fused(c, y, c2)
    return (a0, a1, a2), (b0, b1, b2), (c0, c1, c2)


@inner(forceinline=True)
def _columns_of_higher(reference, at, weights, lanes, first, radius):  # type: ignore[no-untyped-def]
    """Products of the slopes, times y^3 and y^4, summed likewise."""
    a3 = a4 = b3 = b4 = c3 = c4 = spread(0.0)
    stride = reference.shape[2]
    plane = reference.shape[1] * stride
    for j in range(weights.shape[0]):
        y = float(j - radius)
        slope_x = load(reference, at + j * stride + plane)
        slope_y = load(reference, at + j * stride + 2 * plane)
        weight = load(weights, j * lanes + first) * spread(y * y * y)
        wx = slope_x * weight
        a, b, c = wx * slope_x, wx * slope_y, slope_y * slope_y * weight
        a3, b3, c3 = a3 + a, b3 + b, c3 + c
        a4, b4, c4 = fused(a, spread(y), a4), fused(b, spread(y), b4), fused(c, spread(y), c4)
    return (a3, a4), (b3, b4), (c3, c4)


@inner(forceinline=True)
def _columns_of_sums(reference, at, weights, lanes, first, radius, mean):  # type: ignore[no-untyped-def]
    """Grey, its square, slopes and grey times slopes, summed likewise."""
    f0 = f1 = spread(0.0)
    a0 = a1 = a2 = b0 = b1 = b2 = c0 = c1 = c2 = d0 = d1 = d2 = spread(0.0)
    stride = reference.shape[2]
    plane = reference.shape[1] * stride
    for j in range(weights.shape[0]):
        y = spread(float(j - radius))
        weight = load(weights, j * lanes + first)
        grey = (load(reference, at + j * stride) - spread(mean)) * weight
        a = load(reference, at + j * stride + plane) * weight
        b = load(reference, at + j * stride + 2 * plane) * weight
        f0, f1 = f0 + grey, fused(grey, grey, f1)
        a0, b0 = a0 + a, b0 + b
        c0, d0 = fused(grey, a, c0), fused(grey, b, d0)
        a, b = a * y, b * y
        a1, b1 = a1 + a, b1 + b
        c1, d1 = fused(grey, a, c1), fused(grey, b, d1)
        a, b = a * y, b * y
        a2, b2 = a2 + a, b2 + b
        c2, d2 = fused(grey, a, c2), fused(grey, b, d2)
    return (f0, f1), (a0, a1, a2), (b0, b1, b2), (c0, c1, c2), (d0, d1, d2)


@inner(forceinline=True)
def _add_products(columns, xs, out):  # type: ignore[no-untyped-def]
    """Add columns, times powers of x, to the moments x^a y^b, a + b <= 2."""
    out[0] += total(columns[0])
    out[1] += total(columns[0] * xs)
    out[2] += total(columns[1])
    out[3] += total(columns[0] * xs * xs)
    out[4] += total(columns[1] * xs)
    out[5] += total(columns[2])


@inner(forceinline=True)
def _add_higher(columns, higher, xs, out):  # type: ignore[no-untyped-def]
    """Add the same of a + b = 3 and 4; `higher` are the columns times y^3 and y^4."""
    xxx = xs * xs * xs
    out[6] += total(columns[0] * xxx)
    out[7] += total(columns[1] * xs * xs)
    out[8] += total(columns[2] * xs)
    out[9] += total(higher[0])
    out[10] += total(columns[0] * xxx * xs)
    out[11] += total(columns[1] * xxx)
    out[12] += total(columns[2] * xs * xs)
    out[13] += total(higher[0] * xs)
    out[14] += total(higher[1])


@inner(forceinline=True)
def _add_sums(columns, xs, second, out):  # type: ignore[no-untyped-def]
    """Add columns, times powers of x, to the moments of 1, x, y, x^2, x y, y^2."""
    out[0] += total(columns[0])
    out[1] += total(columns[0] * xs)
    out[2] += total(columns[1])
    if second is not None:
        out[3] += total(columns[0] * xs * xs)
        out[4] += total(columns[1] * xs)
        out[5] += total(columns[2])


@inner(forceinline=True)
def _add_grey(columns, out):  # type: ignore[no-untyped-def]
    """Add the sums of grey and its square."""
    out[0] += total(columns[0])
    out[1] += total(columns[1])


@inner(fastmath=VECTOR_FLAGS)
def reference_moments(  # type: ignore[no-untyped-def]
    reference, weights, lane_x, row, col, mean, second, products, total, along
):  # fmt: skip
    """Sum up one subset of the reference.

    Parameters
    ----------
    reference : (3, H, W) float32
        Grey, slope along x, slope along y.
    weights : (R, L) float32
        1 for pixels that count, else 0; L is a multiple of LANES.
    lane_x : (L,) float32
        Local x of the columns.
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
    for k in range(3):
        clear(products[k])
    clear(total)
    clear(along)
    width, lanes = weights.shape
    radius = (width - 1) // 2
    for first in range(0, lanes, LANES):
        at = row * reference.shape[2] + col + first
        xs = load(lane_x, first)
        xx, xy, yy = _columns_of_products(reference, at, weights, lanes, first, radius)
        _add_products(xx, xs, products[0])
        _add_products(xy, xs, products[1])
        _add_products(yy, xs, products[2])
        if second is not None:
            fxx, fxy, fyy = _columns_of_higher(reference, at, weights, lanes, first, radius)
            _add_higher(xx, fxx, xs, products[0])
            _add_higher(xy, fxy, xs, products[1])
            _add_higher(yy, fyy, xs, products[2])
        grey, slope_x, slope_y, grey_x, grey_y = _columns_of_sums(
            reference, at, weights, lanes, first, radius, mean
        )
        _add_grey(grey, along)
        _add_sums(slope_x, xs, second, total[3:9])
        _add_sums(slope_y, xs, second, total[9:15])
        _add_sums(grey_x, xs, second, along[3:9])
        _add_sums(grey_y, xs, second, along[9:15])


@inner()
def fill_hessian(  # type: ignore[no-untyped-def]
    products: Floats, total: Floats, along: Floats, count, energy, terms, hessian
) -> None:
    """Hessian of the normalised residual from the moments of the reference.

    What gain and offset of the grey can explain is taken out. Rows are the terms along x,
    then those along y; only the lower triangle is filled.
    """
    per_count, per_energy = 1.0 / count, 1.0 / energy
    for block in range(3):
        first, second = (block + 1) // 2, block // 2  # xx, yx, yy
        for s in range(terms):
            at_s = 3 + 6 * first + s
            one, own = total[at_s] * per_count, along[at_s] * per_energy
            for t in range(terms if block == 1 else s + 1):
                at_t = 3 + 6 * second + t
                hessian[first * terms + s, second * terms + t] = (
                    products[block, _PRODUCT[s, t]] - one * total[at_t] - own * along[at_t]
                )
