"""Green-Lagrange strain of triangles, each homogeneous: of grid cells or of any mesh."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints


def facet_strain(reference: Floats, deformed: Floats) -> Floats:
    """Measure the homogeneous strain of each triangle between neighbouring grid points.

    Every cell is cut from its first corner (r, c) to (r+1, c+1). The first triangle holds
    the edge along row r, the second the edge along row r+1.

    Parameters
    ----------
    reference, deformed : (R, C, 3)
        Positions of the same material, each in its own frame, mm; NaN where unknown.

    Returns
    -------
    (R-1, C-1, 2, 2, 2)
        Green-Lagrange tensor E = (F^T F - I) / 2 of the two triangles (third axis) in an
        orthonormal basis whose first axis is the triangle's edge along the row and whose
        second turns from it towards the next row; NaN where a corner is unknown or the
        reference triangle has no area.

    Notes
    -----
    A triangle has one strain only, so this is exact for a homogeneous deformation of any
    size, and second order in the spacing for the strain at the triangle's centroid.
    """
    return _strain_of_edges(_edges(reference), _edges(deformed))


def triangle_strain(reference: Floats, deformed: Floats, faces: Ints) -> Floats:
    """Measure the homogeneous strain of each triangle of a mesh whose points are known twice.

    Parameters
    ----------
    reference, deformed : (V, 3)
        Positions of the same points, each in its own frame; NaN where unknown.
    faces : (F, 3)

    Returns
    -------
    (F, 2, 2)
        Green-Lagrange tensor in an orthonormal basis of the reference triangle, the first
        axis along its first edge; NaN where a corner is unknown or there is no area.

    Notes
    -----
    The strain of a linear (constant strain) triangle, so it equals that of finite elements
    of this kind to rounding.
    """
    sides = [
        (points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
        for points in (reference, deformed)
    ]
    return _strain_of_edges(*sides)


def _strain_of_edges(before: tuple[Floats, Floats], after: tuple[Floats, Floats]) -> Floats:
    inverse = _inverse_of_basis(*before)
    cauchy_green = np.swapaxes(inverse, -1, -2) @ _gram(*after) @ inverse
    strain: Floats = (cauchy_green - np.eye(2)) / 2
    return strain


def _edges(points: Floats) -> tuple[Floats, Floats]:
    """Edges along the row and towards the next row, (R-1, C-1, 2, 3) each."""
    first, right = points[:-1, :-1], points[:-1, 1:]
    below, opposite = points[1:, :-1], points[1:, 1:]
    along = np.stack([right - first, opposite - below], axis=2)
    across = np.stack([opposite - right, below - first], axis=2)
    return along, across


def _gram(along: Floats, across: Floats) -> Floats:
    """Scalar products of two edges, (..., 2, 2)."""
    pair = np.stack([along, across], axis=-2)
    products: Floats = pair @ np.swapaxes(pair, -1, -2)
    return products


def _inverse_of_basis(along: Floats, across: Floats) -> Floats:
    """Inverse of the matrix whose columns are the two edges in their own plane."""
    length = np.linalg.norm(along, axis=-1)
    height = np.linalg.norm(np.cross(along, across), axis=-1)
    sound = height > 0
    length, height = np.where(sound, length, np.nan), np.where(sound, height, np.nan)
    inverse = np.zeros((*length.shape, 2, 2))
    inverse[..., 0, 0] = 1 / length
    inverse[..., 0, 1] = -np.sum(along * across, axis=-1) / (length * height)
    inverse[..., 1, 1] = length / height
    return inverse
