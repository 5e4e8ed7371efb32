"""Outward directions of a surface that is known at points in rows and columns."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import DataError

_REACH = 2  # rows and columns to each side
_TERMS = 6  # of a quadratic of row and column


def outward_normals(points: Floats, lattice: Ints) -> Floats:
    """Fit a quadratic of row and column about each point; outward is away from the middle of all.

    Parameters
    ----------
    points : (P, 3)
        On a surface that bulges outward: a cylinder, a cone, a part of them.
    lattice : (P, 2)
        Row and column of each.

    Returns
    -------
    (P, 3)
        Unit vectors.

    Raises
    ------
    DataError
        If a point has too few neighbours.
    """
    normals = np.empty(points.shape)
    for number, place in enumerate(lattice):
        steps = lattice - place
        near = (np.abs(steps) <= _REACH).all(axis=1)
        r, c = steps[near].T.astype(np.float64)
        terms = np.stack([np.ones(len(r)), r, c, r * r, r * c, c * c], axis=1)
        if np.linalg.matrix_rank(terms) < _TERMS:
            row, column = place.tolist()
            raise DataError(
                f"the point in row {row}, column {column} has too few neighbours to tell which "
                "way the surface faces: give nx, ny, nz"
            )
        slopes = np.linalg.lstsq(terms, points[near])[0]
        normals[number] = np.cross(slopes[1], slopes[2])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    outward = ((points - points.mean(axis=0)) * normals).sum(axis=1)
    return normals * np.where(outward < 0, -1.0, 1.0)[:, None]
