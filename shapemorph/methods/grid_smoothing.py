"""Smooth values on a grid by local quadratic surfaces."""

import itertools
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats

_TERMS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
_RIDGE = 1e-6  # of the weight: keeps fits at rims and corners solvable
_REACH = 3.0  # standard deviations at which the weights end
ENOUGH = 0.05  # weight of measured points that a gap is filled from


@dataclass(frozen=True, slots=True, eq=False)
class GridSmoother:
    """Quadratic surfaces around every point of a grid, with Gaussian weights.

    Attributes
    ----------
    weight : (R, C)
        Of each value, from 0, where it is not known, to 1.
    bells : tuple of (K,)
        Gaussian weights along an axis, times powers of the distance.
    sound : (R, C) bool
        Where known points lie on all sides, or near, so that the fit is one.
    gain : (6, R, C, 1)
        What makes moments of the values into the surface at its own centre.
    """

    weight: Floats
    bells: tuple[Floats, ...]
    sound: Bools
    gain: Floats

    @classmethod
    def over(cls, weight: Floats, *, reach: float) -> "GridSmoother":
        """Prepare for values of some weight (R, C); `reach`: standard deviation, in points."""
        half = int(np.ceil(_REACH * reach))
        offsets = np.arange(-half, half + 1) / reach
        bells = tuple(np.exp(-0.5 * offsets**2) * offsets**n for n in range(5))
        table = {
            (a, b): _moment(weight, bells[a], bells[b]) for a in range(5) for b in range(5 - a)
        }
        sound = table[0, 0] > ENOUGH * bells[0].sum() ** 2
        normal = np.empty((np.count_nonzero(sound), len(_TERMS), len(_TERMS)))
        for (i, p), (j, q) in itertools.product(enumerate(_TERMS), repeat=2):
            normal[:, i, j] = table[p[0] + q[0], p[1] + q[1]][sound]
        normal += _RIDGE * table[0, 0][sound][:, None, None] * np.eye(len(_TERMS))
        centre = np.zeros((len(normal), len(_TERMS), 1))
        centre[:, 0] = 1.0
        gain = np.zeros((len(_TERMS), *weight.shape, 1))
        gain[:, sound] = np.linalg.solve(normal, centre).transpose(1, 0, 2)
        return cls(weight, bells, sound, gain)

    def __call__(self, values: Floats) -> Floats:
        """Fit the surfaces to values (R, C, D); 0 where they are not sound."""
        weight = self.weight[..., None]
        weighted = np.where(weight > 0, values, 0.0) * weight
        smooth = np.zeros_like(weighted)
        for gain, (a, b) in zip(self.gain, _TERMS, strict=True):
            smooth += gain * _moment(weighted, self.bells[a], self.bells[b])
        return smooth


def _moment(field: Floats, along_x: Floats, along_y: Floats) -> Floats:
    """Weighted sums of an (R, C) or (R, C, D) field around every point; 0 beyond it."""
    import cv2

    found = cv2.sepFilter2D(field, -1, along_x, along_y, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(found, dtype=np.float64).reshape(field.shape)


def bends(values: Floats) -> Floats:
    """Second order terms of an (R, C, D) grid at every point, of x^2, x y and y^2 in points.

    Beyond the border the grid goes on straight.

    Returns
    -------
    (R, C, D, 3)
    """
    around = np.pad(values, ((1, 1), (1, 1), (0, 0)), mode="reflect", reflect_type="odd")
    along_x = around[1:-1, 2:] - 2.0 * values + around[1:-1, :-2]
    along_y = around[2:, 1:-1] - 2.0 * values + around[:-2, 1:-1]
    twist = around[2:, 2:] - around[2:, :-2] - around[:-2, 2:] + around[:-2, :-2]
    return np.stack([0.5 * along_x, 0.25 * twist, 0.5 * along_y], axis=-1)


def fill_gaps(values: Floats, known: Bools) -> Floats:
    """Fill what is not known of an (R, C, D) grid with local means of what is."""
    filled = np.where(known[..., None], values, 0.0)
    given = np.concatenate([filled, known[..., None]], axis=-1)
    missing = ~known
    reach, largest = 1.0, float(max(known.shape))
    while missing.any() and known.any():
        means = _means(given, reach)
        weight = means[..., -1]
        near = missing & ((weight > ENOUGH) | (reach > largest))
        filled[near] = means[near, :-1] / np.maximum(weight[near], 1e-12)[:, None]
        missing &= ~near
        reach *= 2.0
    return filled


def _means(values: Floats, reach: float) -> Floats:
    """Average an (R, C, D) grid with Gaussian weights; it is 0 beyond its border."""
    offsets = np.arange(-int(4.0 * reach + 0.5), int(4.0 * reach + 0.5) + 1)
    bell = np.exp(-0.5 * (offsets / reach) ** 2)
    return _moment(values, bell / bell.sum(), bell / bell.sum())
