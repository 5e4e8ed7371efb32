"""Triangles to pixels: each pixel centre goes to exactly one triangle.

Rows are worked in bands, each by one thread, triangles in their order within a band:
the result does not depend on the number of threads.
"""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.kernels.orientation import owns, side

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


@njit(cache=True, parallel=True)
def rasterise(
    px: Floats, faces: Ints, sign: float, height: int, width: int
) -> tuple[Triangles, Floats, Ints]:
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
    overlaps : (B,)
        Times that a triangle found its pixel centre taken, for each band of rows.
    """
    triangle = np.full((height, width), -1, np.int32)
    barycentric = np.full((height, width, 2), np.nan)
    starts, items = _sort_into_bands(px, faces, height)
    overlaps = np.zeros(len(starts) - 1, np.int64)
    for band in prange(len(starts) - 1):
        for item in range(starts[band], starts[band + 1]):
            k = items[item]
            ax, ay = px[faces[k, 0], 0], px[faces[k, 0], 1]
            bx, by = px[faces[k, 1], 0], px[faces[k, 1], 1]
            cx, cy = px[faces[k, 2], 0], px[faces[k, 2], 1]
            area = side(ax, ay, bx, by, cx, cy)
            if area * sign <= 0.0:
                continue
            top = max(band * ROWS_PER_BAND, int(np.ceil(min(ay, by, cy))))
            bottom = min((band + 1) * ROWS_PER_BAND, height, int(np.floor(max(ay, by, cy))) + 1)
            left = max(0, int(np.ceil(min(ax, bx, cx))))
            right = min(width, int(np.floor(max(ax, bx, cx))) + 1)
            for row in range(top, bottom):
                y = float(row)
                for col in range(left, right):
                    x = float(col)
                    if not (
                        owns(sign, ax, ay, bx, by, x, y)
                        and owns(sign, bx, by, cx, cy, x, y)
                        and owns(sign, cx, cy, ax, ay, x, y)
                    ):
                        continue
                    if triangle[row, col] >= 0:
                        overlaps[band] += 1
                        continue
                    triangle[row, col] = k
                    barycentric[row, col, 0] = side(cx, cy, ax, ay, x, y) / area
                    barycentric[row, col, 1] = side(ax, ay, bx, by, x, y) / area
    return triangle, barycentric, overlaps


@njit(cache=True)
def fill_polygon(corners: Floats, height: int, width: int) -> Bools:
    """Mark the pixel centres inside a polygon (even-odd rule).

    Parameters
    ----------
    corners : (K, 2)
        (x, y) in px, pixel centres at integers.
    """
    inside = np.zeros((height, width), np.bool_)
    count = len(corners)
    crossings = np.empty(count)
    for row in range(height):
        found = 0
        for k in range(count):
            x0, y0 = corners[k, 0], corners[k, 1]
            x1, y1 = corners[(k + 1) % count, 0], corners[(k + 1) % count, 1]
            if (y0 <= row) != (y1 <= row):
                crossings[found] = x0 + (row - y0) / (y1 - y0) * (x1 - x0)
                found += 1
        ordered = np.sort(crossings[:found])
        for pair in range(0, found - 1, 2):
            left = max(0, int(np.ceil(ordered[pair])))
            right = min(width - 1, int(np.floor(ordered[pair + 1])))
            inside[row, left : right + 1] = True
    return inside
