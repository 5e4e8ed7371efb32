"""Scalable locally injective map: little stretch, and no triangle turned over.

References
----------
M. Rabinovich et al., Scalable locally injective mappings, ACM Trans. Graph. 36 (2017),
doi 10.1145/2983621.
"""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.methods.parametrize.boundary_first import parametrise_boundary_first
from shapemorph.methods.parametrize.frames import unit_median_scale
from shapemorph.methods.parametrize.harmonic_disk import parametrise_on_disk
from shapemorph.methods.parametrize.untangle import flipped_faces, untangle

MOST_STEPS = 20
SETTLED = 1e-3  # change of a vertex in one step, of the size of the surface


def parametrise_slim(vertices: Floats, faces: Ints) -> Floats:
    """Flatten a disk with holes, weighing stretch and compression alike.

    It starts from the boundary-first map, mended, or where that stays folded from the map
    onto a disk; the symmetric Dirichlet energy then keeps every triangle the right way up.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
        A disk with holes.

    Returns
    -------
    (V, 2)
        In the unit of the vertices, x right, y up, faces counter-clockwise.

    Raises
    ------
    StageError
        If no map without folds is found to start from, or the solution is not finite.
    """
    import igl

    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    space = (vertices - vertices.mean(axis=0)) / size
    plane = unit_median_scale(space, faces, _start(space, faces))
    data = igl.slim_precompute(
        np.asfortranarray(space),
        np.asfortranarray(faces.astype(np.int32)),
        np.asfortranarray(plane),
        igl.MappingEnergyType.SYMMETRIC_DIRICHLET,
        np.zeros(0, dtype=np.int32),
        np.zeros((0, 2), order="F"),
        0.0,
    )
    for _ in range(MOST_STEPS):
        before = plane
        plane = np.array(igl.slim_solve(data, 1), order="C")[:, :2]
        if np.abs(plane - before).max() < SETTLED:
            break
    if not np.isfinite(plane).all():
        raise StageError("locally injective flattening (slim) found no finite solution")
    return np.ascontiguousarray(plane) * size


def _start(vertices: Floats, faces: Ints) -> Floats:
    """Find a map in which no triangle lies upside down."""
    plane = parametrise_boundary_first(vertices, faces)
    if flipped_faces(vertices, faces, plane).any():
        plane = untangle(vertices, faces, plane)
    if flipped_faces(vertices, faces, plane).any():
        plane = parametrise_on_disk(vertices, faces)
    if flipped_faces(vertices, faces, plane).any():
        raise StageError(
            "locally injective flattening (slim): no map without folds to start from: the mesh "
            "has triangles without area; set flatten.method=bff or repair the mesh"
        )
    return plane
