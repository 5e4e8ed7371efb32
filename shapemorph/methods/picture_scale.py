"""Scale of a flattened picture, triangle by triangle."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.image import Chart
from shapemorph.core.mesh import TexturedMesh


def mm_per_px(mesh: TexturedMesh, chart: Chart, face: Ints) -> Floats:
    """Differentiate positions on the surface by picture coordinates.

    Parameters
    ----------
    mesh : TexturedMesh
    chart : Chart
    face : (N,)
        Faces of the mesh, -1 for points off the surface.

    Returns
    -------
    (N, 3, 2)
        Constant within a triangle; NaN off the surface, for faces that the chart leaves
        out and for triangles without area in the picture.
    """
    place = np.full(len(mesh.faces) + 1, -1)  # the last entry answers for face -1
    place[chart.face_ids] = np.arange(len(chart.face_ids))
    triangle = place[face]
    sides = _sides(chart.corner_px[triangle])
    determinant = np.linalg.det(sides)
    sound = (triangle >= 0) & (determinant != 0)
    sides = np.where(sound[:, None, None], sides, np.eye(2))
    scale = _sides(mesh.vertices[mesh.faces[face]]) @ np.linalg.inv(sides)
    return np.where(sound[:, None, None], scale, np.nan)


def _sides(corners: Floats) -> Floats:
    """Vectors from the first corner to the others, as columns, (N, D, 2)."""
    return np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
