"""As rigid as possible: every triangle keeps its size and shape as far as the others allow.

References
----------
L. Liu et al., A local/global approach to mesh parameterization, Comput. Graph. Forum 27
(2008), doi 10.1111/j.1467-8659.2008.01290.x.
"""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.methods.parametrize.boundary_first import parametrise_boundary_first
from shapemorph.methods.parametrize.frames import unit_median_scale

ROUNDS = 5  # of libigl's local and global steps between two looks at the change
MOST_LOOKS = 40
SETTLED = 1e-4  # change of a vertex between two looks, of the size of the surface


def parametrise_arap(vertices: Floats, faces: Ints) -> Floats:
    """Flatten a disk with holes with as little stretch as can be, from the boundary-first map.

    Triangles may turn over where the surface is far from developable.

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
        If the equations have no finite solution.
    """
    import igl

    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    space = (vertices - vertices.mean(axis=0)) / size
    plane = unit_median_scale(space, faces, parametrise_boundary_first(space, faces))
    data = igl.ARAPData()
    data.max_iter = ROUNDS
    data.energy = igl.ARAP_ENERGY_TYPE_ELEMENTS
    igl.arap_precomputation(space, faces, 2, np.zeros(1, dtype=np.int32), data)
    for _ in range(MOST_LOOKS):
        before = plane
        plane = igl.arap_solve(plane[:1].copy(), data, plane)
        if np.abs(plane - before).max() < SETTLED:
            break
    if not np.isfinite(plane).all():
        raise StageError("as-rigid-as-possible flattening found no finite solution")
    placed: Floats = np.ascontiguousarray(plane) * size
    return placed
