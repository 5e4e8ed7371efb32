"""Find the triangle of a chart under any point, exactly, through a grid of buckets."""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Floats, Ints
from shapemorph.kernels.orientation import owns, side


@njit(cache=True)
def _cell(value: float, origin: float, size: float, count: int) -> int:
    return min(max(int(np.floor((value - origin) / size)), 0), count - 1)


@njit(cache=True, nogil=True)
def fill_buckets(
    px: Floats, faces: Ints, sign: float, grid: Floats, rows: int, cols: int
) -> tuple[Ints, Ints]:
    """List the triangles whose bounding box touches each cell of a grid.

    Parameters
    ----------
    px : (N, 2)
    faces : (M, 3)
        Those whose signed area has not the sign of `sign` are left out.
    sign : float
        +1 or -1.
    grid : (4,)
        x and y of the grid's corner, width of a cell, tolerance; px.
    rows, cols : int
        Cells of the grid.

    Returns
    -------
    starts : (rows * cols + 1,)
    items : (T,)
        Triangles of cell c, in order, are ``items[starts[c]:starts[c + 1]]``.
    """
    span = np.empty((len(faces), 4), np.int64)
    starts = np.zeros(rows * cols + 1, np.int64)
    slack = grid[3]
    for k in range(len(faces)):
        ax, ay = px[faces[k, 0], 0], px[faces[k, 0], 1]
        bx, by = px[faces[k, 1], 0], px[faces[k, 1], 1]
        cx, cy = px[faces[k, 2], 0], px[faces[k, 2], 1]
        span[k, 0], span[k, 1] = 0, -1
        if side(ax, ay, bx, by, cx, cy) * sign <= 0.0:
            continue
        span[k, 0] = _cell(min(ay, by, cy) - slack, grid[1], grid[2], rows)
        span[k, 1] = _cell(max(ay, by, cy) + slack, grid[1], grid[2], rows)
        span[k, 2] = _cell(min(ax, bx, cx) - slack, grid[0], grid[2], cols)
        span[k, 3] = _cell(max(ax, bx, cx) + slack, grid[0], grid[2], cols)
        for row in range(span[k, 0], span[k, 1] + 1):
            for col in range(span[k, 2], span[k, 3] + 1):
                starts[row * cols + col + 1] += 1
    starts = np.cumsum(starts)
    items = np.empty(starts[-1], np.int64)
    ends = starts.copy()
    for k in range(len(faces)):
        for row in range(span[k, 0], span[k, 1] + 1):
            for col in range(span[k, 2], span[k, 3] + 1):
                items[ends[row * cols + col]] = k
                ends[row * cols + col] += 1
    return starts, items


@njit(cache=True)
def holds(px: Floats, faces: Ints, sign: float, k: int, x: float, y: float) -> bool:
    """Whether triangle k owns the point; of two neighbours only one does."""
    ax, ay = px[faces[k, 0], 0], px[faces[k, 0], 1]
    bx, by = px[faces[k, 1], 0], px[faces[k, 1], 1]
    if not owns(sign, ax, ay, bx, by, x, y):
        return False
    cx, cy = px[faces[k, 2], 0], px[faces[k, 2], 1]
    return bool(owns(sign, bx, by, cx, cy, x, y) and owns(sign, cx, cy, ax, ay, x, y))


@njit(cache=True)
def weights(px: Floats, faces: Ints, k: int, x: float, y: float) -> tuple[float, float]:
    """Barycentric weights of the second and third corner of triangle k."""
    ax, ay = px[faces[k, 0], 0], px[faces[k, 0], 1]
    bx, by = px[faces[k, 1], 0], px[faces[k, 1], 1]
    cx, cy = px[faces[k, 2], 0], px[faces[k, 2], 1]
    area = side(ax, ay, bx, by, cx, cy)
    return side(cx, cy, ax, ay, x, y) / area, side(ax, ay, bx, by, x, y) / area


@njit(cache=True)
def _depth(px: Floats, faces: Ints, sign: float, k: int, x: float, y: float) -> float:
    """Distance of the point from the nearest edge of triangle k, negative outside."""
    depth = np.inf
    for edge in range(3):
        a, b = faces[k, edge], faces[k, (edge + 1) % 3]
        length = np.hypot(px[b, 0] - px[a, 0], px[b, 1] - px[a, 1])
        area = side(px[a, 0], px[a, 1], px[b, 0], px[b, 1], x, y)
        depth = min(depth, sign * area / length)
    return depth


@njit(cache=True)
def find(
    px: Floats,
    faces: Ints,
    sign: float,
    grid: Floats,
    cols: int,
    starts: Ints,
    items: Ints,
    x: float,
    y: float,
) -> int:
    """Find the triangle under a point, -1 where there is none.

    A point that no triangle owns but that lies on the border, or outside by no more than
    the tolerance, goes to the triangle nearest to it.
    """
    if not (np.isfinite(x) and np.isfinite(y)):
        return -1
    rows = (len(starts) - 1) // cols
    col, row = np.floor((x - grid[0]) / grid[2]), np.floor((y - grid[1]) / grid[2])
    if not (-1.0 <= col <= cols and -1.0 <= row <= rows):
        return -1
    cell = min(max(int(row), 0), rows - 1) * cols + min(max(int(col), 0), cols - 1)
    for item in range(starts[cell], starts[cell + 1]):
        if holds(px, faces, sign, items[item], x, y):
            return int(items[item])
    nearest, deepest = -1, -grid[3]
    for item in range(starts[cell], starts[cell + 1]):
        depth = _depth(px, faces, sign, items[item], x, y)
        if depth >= deepest:
            nearest, deepest = items[item], depth
    return int(nearest)


@njit(cache=True, nogil=True, parallel=True)
def _locate_all(
    px: Floats,
    faces: Ints,
    sign: float,
    grid: Floats,
    cols: int,
    starts: Ints,
    items: Ints,
    points: Floats,
    triangle: Ints,
    barycentric: Floats,
) -> None:
    for n in prange(len(points)):
        x, y = points[n, 0], points[n, 1]
        k = find(px, faces, sign, grid, cols, starts, items, x, y)
        if k >= 0:
            triangle[n] = k
            barycentric[n, 0], barycentric[n, 1] = weights(px, faces, k, x, y)


def locate(
    px: Floats,
    faces: Ints,
    sign: float,
    grid: Floats,
    cols: int,
    starts: Ints,
    items: Ints,
    points: Floats,
) -> tuple[Ints, Floats]:
    """Find triangle and barycentric weights of many points.

    The first arguments are those of :func:`fill_buckets` and what it returned.

    Parameters
    ----------
    points : (N, 2)

    Returns
    -------
    triangle : (N,)
        -1 off the chart.
    barycentric : (N, 2)
        Weights of the second and third corner; NaN off the chart.
    """
    triangle = np.full(len(points), -1, np.int64)
    barycentric = np.full((len(points), 2), np.nan)
    _locate_all(px, faces, sign, grid, cols, starts, items, points, triangle, barycentric)
    return triangle, barycentric
