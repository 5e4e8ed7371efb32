"""Two measurements of one pair on different grids, point by point."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.methods.least_squares import fit_operators
from shapemorph.methods.quadratic_fit import WORST_CONDITION, quadratics

_NEIGHBOURS = 16  # of the other grid: a quadratic has 6 coefficients
_REACH = 3.0  # median distances of neighbours beyond which a point has no other measurement


def carried_over(
    places: Floats, normals: Floats, other_places: Floats, other_values: Floats
) -> Floats:
    """Interpolate what one measurement found to the material points of another.

    Parameters
    ----------
    places, normals : (N, 3)
        Reference positions and unit normals of the points that are asked for, mm.
    other_places : (M, 3)
        Reference positions of the other measurement.
    other_values : (M, D)
        What was found there.

    Returns
    -------
    (N, D)
        Quadratics through the 16 nearest points over the tangent plane, at the point; NaN
        where the other measurement has none near, or none on all sides.
    """
    from scipy.spatial import cKDTree

    if len(other_places) < _NEIGHBOURS:
        return np.full((len(places), other_values.shape[1]), np.nan)
    found_near = cKDTree(other_places).query(places, k=_NEIGHBOURS)
    distance, nearest = (np.asarray(part) for part in found_near)
    usual = float(np.median(distance[:, -1]))
    helper = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    basis = np.stack([first, np.cross(normals, first)], axis=2)
    plane = (other_places[nearest] - places[:, None]) @ basis / usual
    inside = np.ones(plane.shape[:2], dtype=bool)
    terms = quadratics(plane)
    operators = fit_operators(terms, inside, worst_condition=WORST_CONDITION)
    found: Floats = np.einsum("nk,nkd->nd", operators[:, 0], other_values[nearest])
    one_sided = np.linalg.norm(plane.mean(axis=1), axis=1) > np.abs(plane).max(axis=(1, 2)) / 2
    found[one_sided | (distance[:, -1] > _REACH * usual)] = np.nan
    return found
