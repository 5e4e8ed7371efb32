"""A turn in the plane between two pictures, which a morph sequence takes along an arc."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.matching import Warp
from shapemorph.methods.warping import warp_points

LEAST_TURN = np.pi / 6
"""Radians; on straight ways a turn of this size shrinks the middle pictures by 3 %."""


@dataclass(frozen=True, slots=True, eq=False)
class Turn:
    """A rigid motion in the plane of which parts can be taken.

    Attributes
    ----------
    angle : float
        From x towards y, radians.
    start, end : (2,) float64
        Where the centre of the turn lies before and after, px.
    """

    angle: float
    start: Floats
    end: Floats

    @property
    def back(self) -> Self:
        """The motion that undoes this one."""
        return type(self)(-self.angle, self.end, self.start)

    def rotation(self, part: float) -> Floats:
        """(2, 2) rotation of a part of the motion."""
        cosine, sine = np.cos(part * self.angle), np.sin(part * self.angle)
        return np.array([[cosine, -sine], [sine, cosine]])

    def carry(self, points: Floats, part: float) -> Floats:
        """Move points (..., 2) by a part of the motion."""
        centre = self.start + part * (self.end - self.start)
        carried: Floats = centre + (points - self.start) @ self.rotation(part).T
        return carried

    def undo(self, points: Floats, part: float) -> Floats:
        """Take a part of the motion out of points (..., 2)."""
        centre = self.start + part * (self.end - self.start)
        undone: Floats = self.start + (points - centre) @ self.rotation(part)
        return undone

    def straighten(self, warp: Warp) -> Warp:
        """Take the whole motion out of where a warp leads."""
        return replace(warp, coefficients=self.undo(warp.coefficients, 1.0))


NO_TURN = Turn(0.0, np.zeros(2), np.zeros(2))


def turn_between(points: Floats, forward: Warp) -> Turn:
    """Find the turn of a warp, where there is one that matters.

    Parameters
    ----------
    points : (P, 2)
        Positions in the reference, px; those that the warp does not reach do not count.
    forward : Warp
        Reference -> deformed.

    Returns
    -------
    Turn
        The rotation that brings the points nearest, about their centres (least squares);
        `NO_TURN` where it is below `LEAST_TURN`.
    """
    there, _ = warp_points(forward, points)
    known = np.isfinite(there).all(axis=1)
    if known.sum() < 2:
        return NO_TURN
    before, after = points[known], there[known]
    start, end = before.mean(axis=0), after.mean(axis=0)
    (x, y), (u, v) = (before - start).T, (after - end).T
    angle = float(np.arctan2(x @ v - y @ u, x @ u + y @ v))
    return NO_TURN if abs(angle) < LEAST_TURN else Turn(angle, start, end)
