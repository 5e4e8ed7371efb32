"""Small dense systems and the algebra of subset warps, on float64 scalars."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.kernels.inner import inner


@inner()
def copy(source: Floats, target: Floats) -> None:
    """Copy all of `target` from `source`; compiles faster than an assignment of slices."""
    for k in range(target.shape[0]):
        target[k] = source[k]


@inner()
def clear(target: Floats) -> None:
    """Set all of a vector to zero."""
    for k in range(target.shape[0]):
        target[k] = 0.0


@inner()
def factor(matrix: Floats, count: int, damping: float, lower: Floats) -> bool:
    """Cholesky factor of a symmetric matrix with its diagonal raised.

    Parameters
    ----------
    matrix : (K, K)
        Only its lower triangle up to `count` is read.
    count : int
        Size of the system.
    damping : float
        The diagonal is multiplied by 1 + damping.
    lower : (K, K)
        Filled with the factor, but with the inverse of its diagonal.

    Returns
    -------
    bool
        False where the matrix is not positive definite to ten digits.
    """
    for i in range(count):
        for j in range(i + 1):
            total = matrix[i, j]
            if i == j:
                total *= 1.0 + damping
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            if i == j:
                if not total > 1e-10 * matrix[i, i]:
                    return False
                lower[i, i] = 1.0 / np.sqrt(total)
            else:
                lower[i, j] = total * lower[j, j]
    return True


@inner()
def solve(lower: Floats, right: Floats, count: int, solution: Floats) -> None:
    """Solve with the factor of :func:`factor`; `solution` (K,) is filled."""
    for i in range(count):
        total = right[i]
        for k in range(i):
            total -= lower[i, k] * solution[k]
        solution[i] = total * lower[i, i]
    for i in range(count - 1, -1, -1):
        total = solution[i]
        for k in range(i + 1, count):
            total -= lower[k, i] * solution[k]
        solution[i] = total * lower[i, i]


@inner()
def _product(a, b, second):  # type: ignore[no-untyped-def]
    """Product of two polynomials in 1, x, y, x^2, x y, y^2, cut after the second degree."""
    constant = a[0] * b[0]
    along_x = a[0] * b[1] + a[1] * b[0]
    along_y = a[0] * b[2] + a[2] * b[0]
    if second is None:
        return constant, along_x, along_y, 0.0, 0.0, 0.0
    xx = a[0] * b[3] + a[1] * b[1] + a[3] * b[0]
    xy = a[0] * b[4] + a[1] * b[2] + a[2] * b[1] + a[4] * b[0]
    yy = a[0] * b[5] + a[2] * b[2] + a[5] * b[0]
    return constant, along_x, along_y, xx, xy, yy


@inner()
def _inverse(step, second):  # type: ignore[no-untyped-def]
    """Inverse of the small warp x + step(x), to second degree; both of its components."""
    a, b, c, d = 1.0 + step[1], step[2], step[7], 1.0 + step[8]
    det = a * d - b * c
    ia, ib, ic, id_ = d / det, -b / det, -c / det, a / det
    zero = 0.0
    x = (-(ia * step[0] + ib * step[6]), ia, ib, zero, zero, zero)
    y = (-(ic * step[0] + id_ * step[6]), ic, id_, zero, zero, zero)
    if second is None:
        return x, y
    xx = _product(x, x, second)
    xy = _product(x, y, second)
    yy = _product(y, y, second)
    bent_x = np.empty(6)
    bent_y = np.empty(6)
    for k in range(6):
        bent_x[k] = step[3] * xx[k] + step[4] * xy[k] + step[5] * yy[k]
        bent_y[k] = step[9] * xx[k] + step[10] * xy[k] + step[11] * yy[k]
    for k in range(6):
        u, v = bent_x[k], bent_y[k]
        bent_x[k] = x[k] - ia * u - ib * v
        bent_y[k] = y[k] - ic * u - id_ * v
    return (
        (bent_x[0], bent_x[1], bent_x[2], bent_x[3], bent_x[4], bent_x[5]),
        (bent_y[0], bent_y[1], bent_y[2], bent_y[3], bent_y[4], bent_y[5]),
    )


@inner()
def compose_with_inverse(warp: Floats, step: Floats, second: int | None, result: Floats) -> None:
    """Replace a warp W by W o (identity + step)^-1.

    Exact for affine warps; of second-order warps the terms above the second degree are
    dropped, which vanish with the step.

    Parameters
    ----------
    warp, result : (12,)
        x then y as coefficients of 1, x, y, x^2, x y, y^2, the identity included.
    step : (12,)
        The same without the identity.
    second : None or int
        None where all second-degree terms are zero: then they are not even compiled.
    """
    x, y = _inverse(step, second)
    xx = xy = yy = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if second is not None:
        xx, xy, yy = _product(x, x, second), _product(x, y, second), _product(y, y, second)
    for half in (0, 6):
        for k in range(6):
            total = (
                warp[half + 1] * x[k]
                + warp[half + 2] * y[k]
                + warp[half + 3] * xx[k]
                + warp[half + 4] * xy[k]
                + warp[half + 5] * yy[k]
            )
            result[half + k] = total
        result[half] += warp[half]
