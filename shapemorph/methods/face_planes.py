"""Faces of a mesh as points with normals."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints


def face_planes(vertices: Floats, faces: Ints) -> tuple[Floats, Floats]:
    """Find the centre and the unit normal of every face that has an area.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)

    Returns
    -------
    centres, normals : (G, 3)
    """
    corners = vertices[faces]
    crossed = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(crossed, axis=1)
    sound = length > 0
    return corners[sound].mean(axis=1), crossed[sound] / length[sound, None]


def typical_edge(vertices: Floats, faces: Ints) -> float:
    """Median length of the edges of the faces, mm."""
    corners = vertices[faces]
    return float(np.median(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)))
