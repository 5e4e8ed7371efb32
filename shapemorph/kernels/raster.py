"""Triangles to pixels: each pixel centre goes to exactly one triangle.

Rows are worked in bands, each by one thread, triangles in their order within a band:
the result does not depend on the number of threads.
"""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Floats, Ints
from shapemorph.kernels.orientation import side, takes_ties

Triangles = np.ndarray[tuple[int, int], np.dtype[np.int32]]
ROWS_PER_BAND = 16


@njit(cache=True)
def _sort_into_bands(px: Floats, faces: Ints, height: int) -> tuple[Ints, Ints]:
    """List the triangles that touch each band of rows, in order."""
    bands = (height + ROWS_PER_BAND - 1) // ROWS_PER_BAND
    first = np.zeros(len(faces), np.int64)
    last = np.full(len(faces), -1, np.int64)
    starts = np.zeros(bands + 1, np.int64)
    for k in range(len(faces)):
        y0, y1, y2 = px[faces[k, 0], 1], px[faces[k, 1], 1], px[faces[k, 2], 1]
        top = max(0, int(np.ceil(min(y0, y1, y2))))
        bottom = min(height - 1, int(np.floor(max(y0, y1, y2))))
        if top > bottom:
            continue
        first[k], last[k] = top // ROWS_PER_BAND, bottom // ROWS_PER_BAND
        for band in range(first[k], last[k] + 1):
            starts[band + 1] += 1
    starts = np.cumsum(starts)
    items = np.empty(starts[-1], np.int64)
    ends = starts.copy()
    for k in range(len(faces)):
        for band in range(first[k], last[k] + 1):
            items[ends[band]] = k
            ends[band] += 1
    return starts, items


@njit(cache=True)
def _paint_band(
    px: Floats,
    faces: Ints,
    sign: float,
    some: Ints,
    first_row: int,
    end_row: int,
    triangle: Triangles,
    barycentric: Floats,
) -> int:
    """Give the pixels of a band of rows to some triangles; count those claimed again.

    A pixel centre on the border of the surface, which nobody owns, goes to the first
    triangle that it touches; until then it is held as -2 - k.
    """
    width, claimed_again = triangle.shape[1], 0
    for k in some:
        ax, ay = px[faces[k, 0], 0], px[faces[k, 0], 1]
        bx, by = px[faces[k, 1], 0], px[faces[k, 1], 1]
        cx, cy = px[faces[k, 2], 0], px[faces[k, 2], 1]
        area = side(ax, ay, bx, by, cx, cy)
        if area * sign <= 0.0:
            continue
        top = max(first_row, int(np.ceil(min(ay, by, cy))))
        bottom = min(end_row, int(np.floor(max(ay, by, cy))) + 1)
        left = max(0, int(np.ceil(min(ax, bx, cx))))
        right = min(width, int(np.floor(max(ax, bx, cx))) + 1)
        for row in range(top, bottom):
            y = float(row)
            for col in range(left, right):
                x = float(col)
                first = side(bx, by, cx, cy, x, y) * sign
                second = side(cx, cy, ax, ay, x, y) * sign
                third = side(ax, ay, bx, by, x, y) * sign
                if first < 0.0 or second < 0.0 or third < 0.0:
                    continue
                owned = (
                    (first > 0.0 or takes_ties(sign, bx, by, cx, cy))
                    and (second > 0.0 or takes_ties(sign, cx, cy, ax, ay))
                    and (third > 0.0 or takes_ties(sign, ax, ay, bx, by))
                )
                taken = triangle[row, col]
                if owned and taken >= 0:
                    claimed_again += 1
                elif owned or taken == -1:
                    triangle[row, col] = k if owned else -2 - k
                    barycentric[row, col, 0] = second / (area * sign)
                    barycentric[row, col, 1] = third / (area * sign)
    for row in range(first_row, end_row):
        for col in range(width):
            if triangle[row, col] < -1:
                triangle[row, col] = -2 - triangle[row, col]
    return claimed_again


@njit(cache=True, nogil=True, parallel=True)
def _paint(
    px: Floats,
    faces: Ints,
    sign: float,
    starts: Ints,
    items: Ints,
    triangle: Triangles,
    barycentric: Floats,
    overlaps: Ints,
) -> None:
    for band in prange(len(overlaps)):
        overlaps[band] = _paint_band(
            px,
            faces,
            sign,
            items[starts[band] : starts[band + 1]],
            band * ROWS_PER_BAND,
            min((band + 1) * ROWS_PER_BAND, len(triangle)),
            triangle,
            barycentric,
        )


def rasterise(
    px: Floats, faces: Ints, sign: float, height: int, width: int
) -> tuple[Triangles, Floats, int]:
    """Find the triangle under every pixel centre.

    Parameters
    ----------
    px : (N, 2)
        Vertices (x, y), pixel centres at integers.
    faces : (M, 3)
        Triangles; those whose signed area has not the sign of `sign` are left out.
    sign : float
        +1 or -1.
    height, width : int

    Returns
    -------
    triangle : (H, W) int32
        -1 where there is none; where several overlap, the first.
    barycentric : (H, W, 2)
        Weights of the second and third corner; NaN where there is none.
    overlaps : int
        Times that a triangle found a pixel centre taken.
    """
    triangle = np.full((height, width), -1, np.int32)
    barycentric = np.full((height, width, 2), np.nan)
    starts, items = _sort_into_bands(px, faces, height)
    overlaps = np.zeros(len(starts) - 1, np.int64)
    _paint(px, faces, sign, starts, items, triangle, barycentric, overlaps)
    return triangle, barycentric, int(overlaps.sum())
