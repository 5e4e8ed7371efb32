"""Normals of a surface at its vertices and between them."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.image import SurfacePoints
from shapemorph.kernels.facing import face_normals, gather_normals, spread_normals


def vertex_normals(vertices: Floats, faces: Ints, *, passes: int) -> Floats:
    """Average the normals of the faces around each vertex, weighted by area.

    Parameters
    ----------
    vertices : (V, 3)
        mm.
    faces : (F, 3)
    passes : int
        Further averages over the faces around, to calm measured noise; 0 for none.

    Returns
    -------
    (V, 3)
        Unit normals, to the side from which faces are counter-clockwise; NaN for
        vertices without a face of non-zero area.
    """
    corners = np.ascontiguousarray(vertices, dtype=np.float64)
    triangles = np.ascontiguousarray(faces, dtype=np.int64)
    of_faces, normals = np.empty((len(faces), 3)), np.empty((len(vertices), 3))
    face_normals(corners, triangles, of_faces)
    gather_normals(of_faces, triangles, normals)
    for _ in range(passes):
        spread_normals(normals, triangles, of_faces)
        gather_normals(of_faces, triangles, normals)
    return normals


def normals_at(normals: Floats, faces: Ints, points: SurfacePoints) -> Floats:
    """Interpolate vertex normals.

    Parameters
    ----------
    normals : (V, 3)
    faces : (F, 3)
    points : SurfacePoints
        N points.

    Returns
    -------
    (N, 3)
        Unit normals; NaN off the surface.
    """
    found = points.face >= 0
    at_corners = normals[faces[np.where(found, points.face, 0)]]
    mixed = np.einsum("nk,nka->na", points.barycentric, at_corners)
    return np.where(found[:, None], _unit(mixed), np.nan)


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0, length, np.nan)
