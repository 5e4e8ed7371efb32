"""Parallel projection along an axis: Eq. 5 of the paper.

The paper's radius on the virtual sensor is ``sqrt(R^2 - Z^2) MF`` = ``sqrt(X^2 + Y^2) MF``
at an unchanged polar angle: what a camera far away on the Z axis sees.

References
----------
K. Genovese, D. Sorgente, A morphing-based scheme for large deformation analysis with
stereo-DIC, Opt. Lasers Eng. (2017), doi 10.1016/j.optlaseng.2017.06.020, Eq. 5.
"""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.methods.parametrize.frames import screen


def parametrise_orthographic(vertices: Floats, faces: Ints, *, axis: Floats | None) -> Floats:
    """Project a surface onto the plane across an axis.

    Steep walls collapse and what faces away turns over; any topology will do.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
    axis : (3,) or None
        From the surface towards the viewer, any length; None takes the normal of the
        best plane through the surface, on the side that most of its faces look to.

    Returns
    -------
    (V, 2)
        In the unit of the vertices, x right, y up. Along Z these are X and Y.
    """
    towards = mean_axis(vertices, faces) if axis is None else np.asarray(axis, dtype=np.float64)
    towards = towards / np.linalg.norm(towards)
    right, up = screen(towards)
    return np.stack([vertices @ right, vertices @ up], axis=1)


def mean_axis(vertices: Floats, faces: Ints) -> Floats:
    """Find the normal of the best plane through a surface, on its outer side.

    Triangles count by their area.
    """
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1)
    centres = corners.mean(axis=1)
    offsets = centres - np.average(centres, axis=0, weights=area)
    _, directions = np.linalg.eigh((offsets * area[:, None]).T @ offsets)
    axis: Floats = directions[:, 0]
    return axis if normals.sum(axis=0) @ axis >= 0 else -axis
