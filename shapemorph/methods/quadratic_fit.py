"""Quadratic surfaces through the points of windows, about their centres."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.methods.least_squares import fit_operators

WORST_CONDITION = 1e7  # of normal equations in coordinates of order one
_FEWEST_QUADRATIC = 9  # half as many again as the six coefficients
_FEWEST_LINEAR = 4  # one more than the three coefficients


def quadratic_operators(coordinates: Floats, inside: Bools) -> Floats:
    """Find the matrices that turn data into coefficients of 1, x, y, x^2, xy, y^2.

    Planes are fitted where the points are too few for quadratics, or lie in too narrow a
    strip.

    Parameters
    ----------
    coordinates : (N, K, 2)
        Of the points of N windows, from their centres.
    inside : (N, K)
        Which points take part.

    Returns
    -------
    (N, 6, K)
        Coefficients = operator @ data; NaN where the points settle not even a plane.
    """
    scale = width_of(coordinates, inside)
    terms = quadratics(coordinates / scale[:, None, None])
    operators = fit_operators(terms, inside, worst_condition=WORST_CONDITION)
    count = inside.sum(axis=1)
    poor = (count < _FEWEST_QUADRATIC) | ~np.isfinite(operators[:, 0, 0])
    operators[poor] = 0.0
    operators[poor, :3] = fit_operators(
        terms[poor][:, :, :3], inside[poor], worst_condition=WORST_CONDITION
    )
    operators[count < _FEWEST_LINEAR] = np.nan
    powers = np.array([0, 1, 1, 2, 2, 2])
    scaled: Floats = operators / scale[:, None, None] ** powers[:, None]
    return scaled


def quadratics(coordinates: Floats) -> Floats:
    """Monomials 1, x, y, x^2, xy, y^2 of coordinates (N, K, 2), (N, K, 6)."""
    x, y = np.moveaxis(coordinates, 2, 0)
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=2)


def cubics(coordinates: Floats) -> Floats:
    """Cubic monomials x^3, x^2 y, x y^2, y^3 of coordinates (N, K, 2), (N, K, 4)."""
    x, y = np.moveaxis(coordinates, 2, 0)
    xx, yy = x * x, y * y
    return np.stack([xx * x, xx * y, x * yy, yy * y], axis=2)


def cubic_changes(offsets: Ints) -> Floats:
    """Find what cubic terms change in the slopes at the centre of a window, (2, K).

    Parameters
    ----------
    offsets : (K, 2)
        Of the points of a window, in grid points.

    Returns
    -------
    (2, K)
        Times data: slopes, per step of the grid, of the cubic through them, less those of
        the quadratic.
    """
    places = offsets.astype(np.float64)
    plain = quadratics(places[None])[0]
    full = np.column_stack([plain, cubics(places[None])[0]])
    changes: Floats = np.linalg.pinv(full)[1:3] - np.linalg.pinv(plain)[1:3]
    return changes


def width_of(coordinates: Floats, inside: Bools) -> Floats:
    """Root mean square distance from the centre; 1 where there is none, (N,)."""
    squared = np.where(inside, (coordinates**2).sum(axis=2), 0.0).sum(axis=1)
    width = np.sqrt(squared / np.maximum(inside.sum(axis=1), 1))
    return np.where(width > 0, width, 1.0)
