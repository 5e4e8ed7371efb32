"""Normals of a surface at its vertices and between them."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.image import SurfacePoints


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
    corners = vertices[faces]
    crossed = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(crossed, axis=1, keepdims=True)
    normals = _unit(_gathered(crossed, faces, len(vertices)))
    for _ in range(passes):
        of_faces = area * _unit(np.nan_to_num(normals)[faces].sum(axis=1))
        normals = _unit(_gathered(np.nan_to_num(of_faces), faces, len(vertices)))
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


def _gathered(of_faces: Floats, faces: Ints, count: int) -> Floats:
    """Sum a vector of every face into its three vertices."""
    columns = [
        np.bincount(faces.ravel(), weights=np.repeat(of_faces[:, axis], 3), minlength=count)
        for axis in range(3)
    ]
    return np.stack(columns, axis=1)


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0, length, np.nan)
