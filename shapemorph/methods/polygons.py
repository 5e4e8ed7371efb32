"""Polygons to triangles, without touching what their corners carry."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.errors import DataError

_MOST_CORNERS = 500


def triangulate(positions: Floats, sizes: Ints) -> tuple[Ints, Ints]:
    """Cut polygons into triangles.

    Convex polygons become fans; a quad with a reflex corner is cut through that corner, and
    larger ones with reflex corners lose ears one by one in their own plane.

    Parameters
    ----------
    positions : (N, 3)
        Position of every corner, polygon after polygon.
    sizes : (P,)
        Corners of each polygon, at least 3.

    Returns
    -------
    corners : (T, 3)
        Rows of `positions`; triangles of one polygon follow each other and keep its sense.
    polygon : (T,)
        Polygon of each triangle.

    Raises
    ------
    DataError
        If a polygon with reflex corners is too large to lose its ears one by one.
    """
    first = np.cumsum(sizes) - sizes
    corners = np.empty((int((sizes - 2).sum()), 3), dtype=np.int64)
    polygon = np.repeat(np.arange(len(sizes)), sizes - 2)
    slot = np.cumsum(sizes - 2) - (sizes - 2)
    for size in np.unique(sizes):
        rows = np.flatnonzero(sizes == size)
        local = _cut_equal(positions, first[rows], int(size))
        corners[slot[rows][:, None] + np.arange(size - 2)] = local + first[rows][:, None, None]
    return corners, polygon


def _cut_equal(positions: Floats, first: Ints, size: int) -> Ints:
    """Cut polygons of one size: (P, size - 2, 3) corner numbers within each polygon."""
    steps = np.arange(1, size - 1)
    fan = np.stack([np.zeros_like(steps), steps, steps + 1], axis=1)
    cuts = np.tile(fan, (len(first), 1, 1))
    if size == 3:
        return cuts
    points = positions[first[:, None] + np.arange(size)]
    reflex = _reflex_corners(points)
    if size == 4:
        turned = reflex[:, 1] | reflex[:, 3]
        cuts[turned] = np.array([[0, 1, 3], [1, 2, 3]])
        return cuts
    crooked = np.flatnonzero(reflex.any(axis=1))
    if len(crooked) and size > _MOST_CORNERS:
        raise DataError(
            f"expected faces of up to {_MOST_CORNERS} corners, got one of {size}: triangulate the "
            "mesh before the export"
        )
    for row in crooked:
        cuts[row] = _clip_ears(points[row])
    return cuts


def _reflex_corners(points: Floats) -> Bools:
    """(P, K) corners where the outline of a polygon (P, K, 3) turns the wrong way."""
    ahead = np.roll(points, -1, axis=1) - points
    behind = points - np.roll(points, 1, axis=1)
    turn = np.cross(behind, ahead)
    total = _area_vector(points)
    reflex: Bools = np.einsum("pkc,pc->pk", turn, total) < 0
    return reflex


def _area_vector(points: Floats) -> Floats:
    """Twice the vector area of each polygon (P, K, 3)."""
    spokes = points - points[:, :1]
    area: Floats = np.cross(spokes[:, 1:-1], spokes[:, 2:]).sum(axis=1)
    return area


def _clip_ears(points: Floats) -> Ints:
    """Cut one polygon (K, 3) by removing ears; falls back to a fan where none is left."""
    flat = _in_own_plane(points)
    left = list(range(len(points)))
    ears = []
    place = 0
    while len(left) > 3:
        onwards = ((place + step) % len(left) for step in range(len(left)))
        place = next((k for k in onwards if _is_ear(flat, left, k)), 1)
        ears.append([left[place - 1], left[place], left[(place + 1) % len(left)]])
        del left[place]
    return np.array([*ears, left], dtype=np.int64)


def _in_own_plane(points: Floats) -> Floats:
    """Coordinates (K, 2) in the plane of the vector area, counter-clockwise."""
    normal = _area_vector(points[None])[0]
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    across = np.cross(axis, normal)
    return np.stack([points @ across, points @ np.cross(normal, across)], axis=1)


def _is_ear(flat: Floats, left: list[int], place: int) -> bool:
    """Whether the corner is convex and its triangle holds no other corner."""
    trio = [left[place - 1], left[place], left[(place + 1) % len(left)]]
    a, b, c = flat[trio]
    if _signed(a, b, c) <= 0:
        return False
    others = flat[[k for k in left if k not in trio]]
    inside = (
        (_signed(a, b, others) >= 0) & (_signed(b, c, others) >= 0) & (_signed(c, a, others) >= 0)
    )
    return not bool(np.any(inside))


def _signed(a: Floats, b: Floats, p: Floats) -> Floats:
    """Twice the signed area of (a, b, p) for one point or many."""
    area: Floats = (b[0] - a[0]) * (p[..., 1] - a[1]) - (b[1] - a[1]) * (p[..., 0] - a[0])
    return area
