"""Green-Lagrange strain of the two triangles of every grid cell."""

import numpy as np

from shapemorph.core.arrays import Floats


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
    along, across = _edges(reference)
    inverse = _inverse_of_basis(along, across)
    gram = _gram(*_edges(deformed))
    cauchy_green = np.swapaxes(inverse, -1, -2) @ gram @ inverse
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
