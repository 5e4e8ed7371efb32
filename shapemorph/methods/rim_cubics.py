"""Cubic terms where a rim cuts the windows of a fit.

In a whole window cubic terms hardly touch the slopes in the middle of a quadratic. At a rim
the centre lies at the border of its window, and they make most of the error there.
"""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.methods.grid_windows import Windows
from shapemorph.methods.least_squares import fit_operators
from shapemorph.methods.quadratic_fit import WORST_CONDITION, cubics, quadratics, width_of

_FEWEST = 15  # half as many again as the ten coefficients
_CLEARLY = 4.6  # times what noise does: one in a hundred of two independent parts reaches it


@dataclass(frozen=True, slots=True, eq=False)
class PointNoise:
    """Errors of the positions of all grid points.

    Attributes
    ----------
    sigma : (P,) float64
        Standard deviation along the surface, both components together, mm; NaN where lost.
    correlation : (K, K) float64
        Between the errors of the points of a window.
    """

    sigma: Floats
    correlation: Floats

    def of(self, windows: Windows, chosen: Bools) -> "PointNoise":
        """Give the errors of the points of some windows: `sigma` (N, K), zero outside."""
        around = self.sigma[windows.neighbours[chosen]]
        return PointNoise(np.where(windows.inside[chosen], around, 0.0), self.correlation)


def with_cubics(
    coordinates: Floats, inside: Bools, operators: Floats, data: Floats, noise: PointNoise
) -> Floats:
    """Add cubic terms to quadratic fits where they say clearly more than noise.

    Parameters
    ----------
    coordinates : (N, K, 2)
        Of the points of N windows, from their centres, mm.
    inside : (N, K)
        Which points take part.
    operators : (N, 6, K)
        Of quadratic fits.
    data : (N, K, 2)
        What is fitted, mm.
    noise : PointNoise
        Of the data at these points.

    Returns
    -------
    (N, 6, K)
        Operators s C + (1 - s) Q of the cubic and the quadratic fit. With d the squared
        change of the slopes between both and n what noise alone makes of it on average,
        s rises from 0 at d = 4.6 n to 1 at twice that.
    """
    full = _cubic_operators(coordinates, inside)
    known = np.asarray(np.isfinite(full + operators).all(axis=(1, 2)))
    change = np.where(known[:, None, None], full - operators, 0.0)
    moved = ((change[:, 1:3] @ data) ** 2).sum(axis=(1, 2))
    weighted = change[:, 1:3] * np.nan_to_num(noise.sigma)[:, None]
    chance = ((weighted @ noise.correlation) * weighted).sum(axis=(1, 2))
    clear = moved / np.maximum(_CLEARLY * chance, np.finfo(float).tiny)
    share = np.clip(clear - 1, 0.0, 1.0)
    mixed: Floats = operators + share[:, None, None] * change
    return mixed


def _cubic_operators(coordinates: Floats, inside: Bools) -> Floats:
    """First six rows of the matrices that turn data into ten coefficients, (N, 6, K)."""
    scale = width_of(coordinates, inside)
    places = coordinates / scale[:, None, None]
    terms = np.concatenate([quadratics(places), cubics(places)], axis=2)
    operators = fit_operators(terms, inside, worst_condition=WORST_CONDITION)[:, :6]
    operators[inside.sum(axis=1) < _FEWEST] = np.nan
    powers = np.array([0, 1, 1, 2, 2, 2])
    scaled: Floats = operators / scale[:, None, None] ** powers[:, None]
    return scaled
