"""Laws of revolution in the plane of the pictures: every point keeps its direction.

With the two centres and the turn between the pictures given, a law is one function: the
radius r_m in the reference picture at which a radius of the deformed picture is shown.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.errors import StageError

Profile: TypeAlias = Callable[[Floats], Floats]
"""(N,) radius in the deformed picture -> (N,) radius in the reference picture, mm."""

RADII = 512  # at which a profile is looked at
LEAST_RISE = 0.02  # of its mean slope: flatter, a profile has as good as turned back
LEAST_REACH = 0.5  # of the deformed picture's radius that a law must serve


@dataclass(frozen=True, slots=True, eq=False)
class RadialPose:
    """How two pictures of one body of revolution lie over each other.

    Attributes
    ----------
    reference_centre, deformed_centre : (2,) float64
        Where the axis meets the two pictures, mm of each picture.
    turn : float
        Angle from a direction in the deformed picture to that in the reference, radians.
    """

    reference_centre: Floats
    deformed_centre: Floats
    turn: float

    def radii(self, deformed: Floats) -> Floats:
        """(N,) distance of points (N, 2) of the deformed picture from its centre."""
        away = deformed - self.deformed_centre
        return np.hypot(away[:, 0], away[:, 1])

    def carry(self, deformed: Floats, profile: Profile) -> Floats:
        """(N, 2) places in the reference picture of points of the deformed picture, mm."""
        radius = self.radii(deformed)
        grown = profile(radius) / np.maximum(radius, 1e-12)
        away = rotate(deformed - self.deformed_centre, self.turn)
        carried: Floats = self.reference_centre + grown[:, None] * away
        return carried


def rotate(vectors: Floats, angle: float) -> Floats:
    """Turn vectors (N, 2) from x towards y."""
    cosine, sine = np.cos(angle), np.sin(angle)
    turned: Floats = vectors @ np.array([[cosine, sine], [-sine, cosine]])
    return turned


def law_pairs(pose: RadialPose, profile: Profile, deformed: Floats) -> tuple[Floats, Floats]:
    """Apply a law of revolution to points of the deformed picture.

    Parameters
    ----------
    pose : RadialPose
    profile : callable
        r_m of the radius; must rise. Points beyond its first turning point are left out.
    deformed : (N, 2)
        Points of the deformed picture, mm.

    Returns
    -------
    source, target : (M, 2)
        Places in the reference picture and the points themselves, mm.

    Raises
    ------
    StageError
        If it turns back too soon to be of use.
    """
    usable = _rising(profile, pose.radii(deformed))
    return pose.carry(deformed[usable], profile), deformed[usable]


def _rising(profile: Profile, radii: Floats) -> Bools:
    """(N,) radii up to the first one at which the profile no longer rises."""
    farthest = float(radii.max())
    looked_at = np.linspace(0.0, farthest, RADII)
    values = profile(looked_at)
    usual = abs(values[-1] - values[0]) / (RADII - 1)
    falls = np.flatnonzero(~(np.diff(values) > LEAST_RISE * usual))
    reach = looked_at[falls[0]] if len(falls) else np.inf
    if reach < LEAST_REACH * farthest:
        raise StageError(
            f"the radial law turns back at {reach:.4g} mm of {farthest:.4g} mm in the deformed "
            "picture: expected a rising r_m; lower morph.order, or check morph.coefficients and "
            "the landmarks"
        )
    chosen: Bools = radii <= reach
    return chosen
