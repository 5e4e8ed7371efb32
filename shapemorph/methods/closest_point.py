"""Points near a mesh to places on it."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.image import SurfacePoints
from shapemorph.core.mesh import TexturedMesh


def closest_points(mesh: TexturedMesh, points: Floats, faces: Ints) -> SurfacePoints:
    """Find the place on some faces of a mesh that is nearest to each point.

    Parameters
    ----------
    mesh : TexturedMesh
    points : (N, 3)
        mm, in the frame of the mesh; must be finite.
    faces : (M,)
        Faces that count.
    """
    import igl

    corners = np.ascontiguousarray(mesh.faces[faces])
    _square, face, foot = igl.point_mesh_squared_distance(
        np.ascontiguousarray(points), mesh.vertices, corners
    )
    triangle = mesh.vertices[corners[face]]
    weights = _weights(np.asarray(foot), triangle)
    return SurfacePoints(np.asarray(faces[face], np.int64), weights)


def _weights(points: Floats, triangles: Floats) -> Floats:
    """(N, 3) barycentric coordinates of points in the planes of triangles (N, 3, 3)."""
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    away = points - triangles[:, 0]
    normal = np.cross(first, second)
    square = np.maximum((normal**2).sum(axis=1), 1e-300)
    v = (np.cross(away, second) * normal).sum(axis=1) / square
    w = (np.cross(first, away) * normal).sum(axis=1) / square
    return np.column_stack([1.0 - v - w, v, w])
