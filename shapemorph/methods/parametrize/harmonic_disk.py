"""A map onto a disk that can neither fold nor overlap: the last resort.

References
----------
W. T. Tutte, How to draw a graph, Proc. London Math. Soc. 13 (1963),
doi 10.1112/plms/s3-13.1.743; M. S. Floater, Parametrization and smooth approximation of
surface triangulations, CAGD 14 (1997), doi 10.1016/S0167-8396(96)00031-3.
"""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.methods.distortion import singular_values
from shapemorph.methods.parametrize.disk import boundary_loops
from shapemorph.methods.parametrize.holes import fill_holes, order_by_length
from shapemorph.methods.parametrize.symmetric_solve import symmetric_solver


def parametrise_on_disk(vertices: Floats, faces: Ints) -> Floats:
    """Map the rim onto a circle by its arc length and the inside harmonically.

    Where the harmonic map folds, every vertex goes between its neighbours instead, which
    cannot fold but is rough on irregular meshes.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
        A disk with holes; holes are filled for the map.

    Returns
    -------
    (V, 2)
        x right, y up, faces counter-clockwise; the circle has the length of the rim.
    """
    loops = order_by_length(vertices, boundary_loops(faces, name="the surface"))
    rim = loops[0]
    closed_vertices, closed_faces = fill_holes(vertices, faces, loops[1:])
    steps = np.linalg.norm(vertices[np.roll(rim, -1)] - vertices[rim], axis=1)
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    angle = 2 * np.pi * travelled[:-1] / travelled[-1]
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1) * travelled[-1] / (2 * np.pi)
    placed = _spread_harmonically(closed_vertices, closed_faces, rim, circle)
    if not (singular_values(closed_vertices, closed_faces, placed).sigma_2 > 0).all():
        placed = spread_between(closed_vertices, closed_faces, rim, circle)
    return placed[: len(vertices)]


def _spread_harmonically(vertices: Floats, faces: Ints, fixed: Ints, positions: Floats) -> Floats:
    """Place the free vertices where the map is harmonic; NaN where that has no solution."""
    import igl

    free = np.setdiff1d(np.arange(len(vertices)), fixed)
    placed = np.full((len(vertices), 2), np.nan)
    placed[fixed] = positions
    rows = (-igl.cotmatrix(vertices, faces)).tocsr()[free].tocsc()
    try:
        placed[free] = symmetric_solver(rows[:, free])(-(rows[:, fixed] @ positions))
    except StageError:  # triangles without area
        return placed
    return placed


def spread_between(vertices: Floats, faces: Ints, fixed: Ints, positions: Floats) -> Floats:
    """Place every vertex at a weighted mean of its neighbours, near ones counting more.

    With the fixed vertices on a convex polygon no triangle turns over.

    Parameters
    ----------
    vertices : (V, 3)
        Distances between them give the weights, 1 / distance.
    faces : (F, 3)
    fixed : (K,)
        Vertices that stay.
    positions : (K, 2)
        Where.

    Returns
    -------
    (V, 2)
    """
    laplacian = _nearness_laplacian(vertices, faces)
    free = np.setdiff1d(np.arange(len(vertices)), fixed)
    placed = np.empty((len(vertices), 2))
    placed[fixed] = positions
    if len(free):
        rows = laplacian[free].tocsc()
        placed[free] = symmetric_solver(rows[:, free])(-(rows[:, fixed] @ positions))
    return placed


def _nearness_laplacian(vertices: Floats, faces: Ints):  # type: ignore[no-untyped-def]
    from scipy.sparse import coo_matrix, diags

    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    weight = 1.0 / np.maximum(length, 1e-6 * length.mean())
    count = len(vertices)
    half = coo_matrix((weight, (edges[:, 0], edges[:, 1])), shape=(count, count)).tocsr()
    both = half + half.T
    return (diags(np.asarray(both.sum(axis=1)).ravel()) - both).tocsr()
