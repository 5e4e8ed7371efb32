"""Boundary-first conformal flattening with no scaling along the rim.

References
----------
R. Sawhney, K. Crane, Boundary First Flattening, ACM Trans. Graph. 37 (2018),
doi 10.1145/3132705.
"""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.methods.parametrize.disk import boundary_loops
from shapemorph.methods.parametrize.holes import fill_holes, order_by_length
from shapemorph.methods.parametrize.symmetric_solve import symmetric_solver


def parametrise_boundary_first(vertices: Floats, faces: Ints) -> Floats:
    """Flatten a disk with holes conformally; its rim keeps its length.

    The logarithm u of the scale vanishes on the rim. That fixes u inside (the curvature
    of the surface is its source), u fixes how much the rim must turn at each of its
    vertices, and the rim fixes the inside as a harmonic map. Three solves share one
    factorisation.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
        A disk with holes, every vertex used; holes are filled for the map.

    Returns
    -------
    (V, 2)
        In the unit of the vertices, x right, y up, faces counter-clockwise.

    Raises
    ------
    StageError
        If the equations have no finite solution.
    """
    import igl

    loops = order_by_length(vertices, boundary_loops(faces, name="the surface"))
    rim = loops[0]
    closed_vertices, closed_faces = fill_holes(vertices, faces, loops[1:])
    count = len(closed_vertices)
    angles = igl.internal_angles(closed_vertices, closed_faces)
    angle_sum: Floats = np.bincount(closed_faces.ravel(), angles.ravel(), minlength=count).astype(
        np.float64
    )
    inside = np.ones(count, dtype=np.bool_)
    inside[rim] = False
    inner = np.flatnonzero(inside)
    laplacian = (-igl.cotmatrix(closed_vertices, closed_faces)).tocsr()
    rows = laplacian[inner].tocsc()
    to_rim = rows[:, rim]
    solve = symmetric_solver(rows[:, inner])
    log_scale = solve(angle_sum[inner] - 2 * np.pi)
    turning: Floats = np.pi - angle_sum[rim] + to_rim.T @ log_scale
    placed = np.empty((count, 2))
    placed[rim] = close_polygon(_edge_lengths(vertices, rim), turning)
    placed[inner] = solve(-(to_rim @ placed[rim]))
    if not np.isfinite(placed).all():
        raise StageError(
            "boundary-first flattening found no finite solution: the mesh has triangles "
            "without area; set flatten.method=orthographic or repair the mesh"
        )
    return placed[: len(vertices)]


def _edge_lengths(vertices: Floats, loop: Ints) -> Floats:
    lengths: Floats = np.linalg.norm(vertices[np.roll(loop, -1)] - vertices[loop], axis=1)
    return lengths


def close_polygon(lengths: Floats, turning: Floats) -> Floats:
    """Lay edges one after another and change their lengths as little as closing takes.

    Parameters
    ----------
    lengths : (K,)
        Wanted length of the edge from corner k to k + 1.
    turning : (K,)
        Exterior angle at corner k, radians.

    Returns
    -------
    (K, 2)
        Corners; the change of each length squared, over the length, is least in sum.
    """
    heading = np.cumsum(turning) - turning[0]
    tangent = np.stack([np.cos(heading), np.sin(heading)])
    gap = tangent @ lengths
    pull = np.linalg.solve((tangent * lengths) @ tangent.T, gap)
    closed = lengths * (1.0 - tangent.T @ pull)
    ends = np.cumsum(tangent * closed, axis=1).T
    corners: Floats = np.roll(ends, 1, axis=0) - ends[-1]
    return corners
