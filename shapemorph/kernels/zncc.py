"""Where a window of one picture is found in another: masked correlation, searched by shifts."""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Bools, Floats, Greys, Ints

_SUM_IN_ANY_ORDER = {"reassoc", "contract", "nsz"}  # unlike fastmath=True this keeps NaN


@njit(cache=True, nogil=True, parallel=True)
def search(
    reference: Greys,
    reference_mask: Greys,
    moved: Greys,
    moved_mask: Greys,
    points: Ints,
    half: int,
    radius: int,
    stride: int,
    least_inside: float,
) -> Floats:
    """Find the shift at which the window round each point looks most alike.

    Pictures are zero outside their masks; masks are 0 or 1. Pixels count where both
    pictures show the specimen. Every `stride`-th shift is tried first, then the best is
    followed uphill pixel by pixel, then refined by a quadratic surface.

    Parameters
    ----------
    reference, reference_mask, moved, moved_mask : (H, W) float32
        Two pictures in one frame.
    points : (N, 2)
        Centres of the windows (x, y), px.
    half : int
        Windows are 2 * half + 1 wide.
    radius : int
        Largest shift that is tried, a multiple of `stride`.
    stride : int
    least_inside : float
        Share of the window that must be visible in both pictures.

    Returns
    -------
    (N, 3)
        Shift (x, y) in px and zero-mean normalised cross-correlation there; NaN where no
        shift counts or the best one lies at the edge of the search.
    """
    found = np.empty((points.shape[0], 3))
    for p in prange(points.shape[0]):
        _search_one(
            reference, reference_mask, moved, moved_mask, points[p, 0], points[p, 1],
            half, radius, stride, least_inside, found[p],
        )  # fmt: skip
    return found


@njit(cache=True)
def _search_one(
    reference: Greys,
    reference_mask: Greys,
    moved: Greys,
    moved_mask: Greys,
    x: int,
    y: int,
    half: int,
    radius: int,
    stride: int,
    least_inside: float,
    found: Floats,
) -> None:
    """Fill in the shift and likeness of one point; NaN where nothing counts."""
    found[:] = np.nan
    scores = np.full((2 * radius + 1, 2 * radius + 1), np.nan)
    best_x, best_y, best = 0, 0, -2.0
    step, first, last = stride, -radius, radius
    centre_x, centre_y = 0, 0
    while True:
        improved = False
        for dy in range(centre_y + first, centre_y + last + 1, step):
            for dx in range(centre_x + first, centre_x + last + 1, step):
                if np.isnan(scores[dy + radius, dx + radius]):
                    scores[dy + radius, dx + radius] = _likeness(
                        reference, reference_mask, moved, moved_mask,
                        x, y, dx, dy, half, least_inside,
                    )  # fmt: skip
                if scores[dy + radius, dx + radius] > best:
                    best, best_x, best_y = scores[dy + radius, dx + radius], dx, dy
                    improved = True
        if best == -2.0 or max(abs(best_x), abs(best_y)) >= radius:
            return  # nothing counts, or the best lies at the edge of the search
        if first == -1 and not improved:
            break
        centre_x, centre_y, step, first, last = best_x, best_y, 1, -1, 1
    row, col = best_y + radius, best_x + radius
    sub_x, sub_y = _summit(scores[row - 1 : row + 2, col - 1 : col + 2])
    if max(abs(sub_x), abs(sub_y)) <= 1.0:
        found[0], found[1], found[2] = best_x + sub_x, best_y + sub_y, best


@njit(cache=True, fastmath=_SUM_IN_ANY_ORDER)
def _likeness(
    reference: Greys,
    reference_mask: Greys,
    moved: Greys,
    moved_mask: Greys,
    x: int,
    y: int,
    dx: int,
    dy: int,
    half: int,
    least_inside: float,
) -> float:
    height, width = reference.shape
    left = max(0, x - half, -dx)
    right = min(width, x + half + 1, width - dx)
    top = max(0, y - half, -dy)
    bottom = min(height, y + half + 1, height - dy)
    n, sum_a, sum_b, sum_aa, sum_bb, sum_ab = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if right <= left:
        return np.nan
    for row in range(top, bottom):
        a_row, a_mask = reference[row, left:right], reference_mask[row, left:right]
        b_row = moved[row + dy, left + dx : right + dx]
        b_mask = moved_mask[row + dy, left + dx : right + dx]
        zero = np.float32(0.0)
        row_n, row_a, row_b, row_aa, row_bb, row_ab = zero, zero, zero, zero, zero, zero
        for k in range(a_row.size):
            a, b = a_row[k] * b_mask[k], b_row[k] * a_mask[k]
            row_n += a_mask[k] * b_mask[k]
            row_a += a
            row_b += b
            row_aa += a * a
            row_bb += b * b
            row_ab += a * b
        n += float(row_n)
        sum_a += float(row_a)
        sum_b += float(row_b)
        sum_aa += float(row_aa)
        sum_bb += float(row_bb)
        sum_ab += float(row_ab)
    if n < least_inside * (2 * half + 1) ** 2:
        return np.nan
    spread = (sum_aa - sum_a * sum_a / n) * (sum_bb - sum_b * sum_b / n)
    if not spread > 1e-9 * n * n:  # no pattern to compare
        return np.nan
    return float((sum_ab - sum_a * sum_b / n) / np.sqrt(spread))


@njit(cache=True)
def _summit(scores: Floats) -> tuple[float, float]:
    """Find the maximum of the quadratic surface through 3 x 3 scores; NaN without one."""
    slope_x = (scores[:, 2].sum() - scores[:, 0].sum()) / 6.0
    slope_y = (scores[2].sum() - scores[0].sum()) / 6.0
    curve_x = (scores[:, 2].sum() - 2.0 * scores[:, 1].sum() + scores[:, 0].sum()) / 3.0
    curve_y = (scores[2].sum() - 2.0 * scores[1].sum() + scores[0].sum()) / 3.0
    twist = (scores[2, 2] - scores[2, 0] - scores[0, 2] + scores[0, 0]) / 4.0
    determinant = curve_x * curve_y - twist * twist
    if not (determinant > 0.0 and curve_x < 0.0):
        return np.nan, np.nan
    x = (twist * slope_y - curve_y * slope_x) / determinant
    y = (twist * slope_x - curve_x * slope_y) / determinant
    return x, y


@njit(cache=True, nogil=True, parallel=True)
def resample_through(
    coefficients: Floats,
    origin: Floats,
    spacing: float,
    picture: Greys,
    mask: Bools,
    height: int,
    width: int,
    scale: float,
) -> tuple[Greys, Greys]:
    """Show a picture in the frame of another through a spline warp, bilinearly.

    Parameters
    ----------
    coefficients, origin, spacing
        Of a warp from the other frame into `picture`.
    picture : (H, W) float32
    mask : (H, W) bool
    height, width : int
        Of the result.
    scale : float
        Pixel (col, row) of the result lies at ``((col + 0.5) / scale - 0.5, ...)`` of the
        other frame.

    Returns
    -------
    values, visible : (height, width) float32
        Zero where the picture or its mask does not reach.
    """
    values = np.empty((height, width), np.float32)
    visible = np.empty((height, width), np.float32)
    for i in prange(height):
        y = ((i + 0.5) / scale - 0.5 - origin[1]) / spacing
        _resample_row(
            coefficients, y, origin[0], spacing, picture, mask, scale, values[i], visible[i]
        )
    return values, visible


@njit(cache=True)
def _resample_row(
    coefficients: Floats,
    y: float,
    origin_x: float,
    spacing: float,
    picture: Greys,
    mask: Bools,
    scale: float,
    values: Greys,
    visible: Greys,
) -> None:
    """Fill in one row of the result, at y in units of the grid of coefficients."""
    values[:], visible[:] = 0.0, 0.0
    rows, cols = coefficients.shape[0], coefficients.shape[1]
    if not (1.0 <= y <= rows - 2.0):
        return
    row = min(int(y), rows - 3)
    line = np.zeros((cols, 2))
    for c in range(cols):
        for j in range(4):
            weight = _weight(y - row, j)
            line[c, 0] += weight * coefficients[row - 1 + j, c, 0]
            line[c, 1] += weight * coefficients[row - 1 + j, c, 1]
    for k in range(values.size):
        x = ((k + 0.5) / scale - 0.5 - origin_x) / spacing
        if not (1.0 <= x <= cols - 2.0):
            continue
        col = min(int(x), cols - 3)
        u, v = 0.0, 0.0
        for j in range(4):
            weight = _weight(x - col, j)
            u += weight * line[col - 1 + j, 0]
            v += weight * line[col - 1 + j, 1]
        if not (0.0 <= u < picture.shape[1] - 1 and 0.0 <= v < picture.shape[0] - 1):
            continue
        a, b = int(v), int(u)
        if mask[a, b] and mask[a, b + 1] and mask[a + 1, b] and mask[a + 1, b + 1]:
            s, t = u - b, v - a
            upper = (1.0 - s) * picture[a, b] + s * picture[a, b + 1]
            lower = (1.0 - s) * picture[a + 1, b] + s * picture[a + 1, b + 1]
            values[k] = (1.0 - t) * upper + t * lower
            visible[k] = 1.0


@njit(cache=True, inline="always")
def _weight(t: float, j: int) -> float:
    """Weight of the j-th of four cubic B-spline knots at offset t."""
    d = abs(t + 1.0 - j)
    if d < 1.0:
        return 2.0 / 3.0 - d * d * (1.0 - 0.5 * d)
    return (2.0 - d) ** 3 / 6.0
