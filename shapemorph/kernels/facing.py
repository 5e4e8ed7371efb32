"""Which way a surface faces at its vertices."""

import math

from numba import njit

from shapemorph.core.arrays import Floats, Ints


@njit(cache=True, nogil=True)
def face_normals(vertices: Floats, faces: Ints, normals: Floats) -> None:
    """Fill in the normal (F, 3) of every face, twice its area long."""
    for face in range(faces.shape[0]):
        a, b, c = faces[face, 0], faces[face, 1], faces[face, 2]
        px, py, pz = (
            vertices[b, 0] - vertices[a, 0],
            vertices[b, 1] - vertices[a, 1],
            vertices[b, 2] - vertices[a, 2],
        )
        qx, qy, qz = (
            vertices[c, 0] - vertices[a, 0],
            vertices[c, 1] - vertices[a, 1],
            vertices[c, 2] - vertices[a, 2],
        )
        normals[face, 0] = py * qz - pz * qy
        normals[face, 1] = pz * qx - px * qz
        normals[face, 2] = px * qy - py * qx


@njit(cache=True, nogil=True)
def gather_normals(of_faces: Floats, faces: Ints, normals: Floats) -> None:
    """Fill in the unit normal (V, 3) of every vertex: the sum of those of its faces.

    Faces without a finite normal count for nothing; a vertex without any is NaN.
    """
    normals[:] = 0.0
    for face in range(faces.shape[0]):
        x, y, z = of_faces[face, 0], of_faces[face, 1], of_faces[face, 2]
        if not math.isfinite(x + y + z):
            continue
        for corner in range(3):
            vertex = faces[face, corner]
            normals[vertex, 0] += x
            normals[vertex, 1] += y
            normals[vertex, 2] += z
    for vertex in range(normals.shape[0]):
        x, y, z = normals[vertex, 0], normals[vertex, 1], normals[vertex, 2]
        length = math.sqrt(x * x + y * y + z * z)
        for axis in range(3):
            normals[vertex, axis] = normals[vertex, axis] / length if length > 0.0 else math.nan


@njit(cache=True, nogil=True)
def spread_normals(normals: Floats, faces: Ints, of_faces: Floats) -> None:
    """Turn the normal (F, 3) of every face to the mean of its vertices, its length kept.

    Vertices without a normal count for nothing.
    """
    for face in range(faces.shape[0]):
        sx, sy, sz = 0.0, 0.0, 0.0
        for corner in range(3):
            vertex = faces[face, corner]
            x, y, z = normals[vertex, 0], normals[vertex, 1], normals[vertex, 2]
            if math.isfinite(x + y + z):
                sx, sy, sz = sx + x, sy + y, sz + z
        length = math.sqrt(sx * sx + sy * sy + sz * sz)
        x, y, z = of_faces[face, 0], of_faces[face, 1], of_faces[face, 2]
        factor = math.sqrt(x * x + y * y + z * z) / length if length > 0.0 else 0.0
        of_faces[face, 0], of_faces[face, 1], of_faces[face, 2] = (
            factor * sx,
            factor * sy,
            factor * sz,
        )
