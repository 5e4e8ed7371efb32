"""Faces of a shape that measured cells lie on, so that a picture of both need not draw them."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints

_AROUND = 4  # cells that meet in a point inside the measured field


def covered_faces(vertices: Floats, faces: Ints, points: Floats, cells: Ints) -> Bools:
    """Tell which faces measured cells cover, with a ring of cells to spare.

    Parameters
    ----------
    vertices : (V, 3)
        Of a shape, mm.
    faces : (F, 3) int64
    points : (N, 3)
        Measured points on that shape, mm; those of cells are finite.
    cells : (M, 4) int64
        Quads between them.

    Returns
    -------
    (F,) bool
        Faces all of whose corners are nearest to points deep inside the field, and as near
        as the cells there are long. The far side of a thin shape is not covered by what was
        measured on the near side, unless it is as near as that.
    """
    from scipy.spatial import cKDTree

    count = len(points)
    inside = np.bincount(cells.ravel(), minlength=count) == _AROUND
    whole = inside[cells].all(axis=1)
    deep = np.bincount(cells[whole].ravel(), minlength=count) == _AROUND
    used = np.unique(cells)
    if not deep.any():
        return np.zeros(len(faces), dtype=bool)
    distance, nearest = cKDTree(points[used]).query(vertices)
    nearest = used[nearest]
    hidden = deep[nearest] & (distance < _reach(points, cells)[nearest])
    covered: Bools = hidden[faces].all(axis=1)
    return covered


def _reach(points: Floats, cells: Ints) -> Floats:
    """Length of the longest side of the cells at each point, (N,); 0 without cells."""
    corners = points[cells]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    reach = np.zeros(len(points))
    np.maximum.at(reach, cells, sides.max(axis=1)[:, None])
    return reach
