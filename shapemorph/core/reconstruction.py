"""A surface seen by two cameras."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Codes, Floats
from shapemorph.core.camera import Rig
from shapemorph.core.errors import DataError
from shapemorph.core.status import PointStatus


@dataclass(frozen=True, slots=True, eq=False)
class Reconstruction:
    """Points of a regular grid of the first picture in space.

    Attributes
    ----------
    rig : Rig
        The two cameras that saw it.
    first_px, second_px : (R, C, 2) float64
        Where both saw the point; second NaN where lost.
    points : (R, C, 3) float64
        In the frame of the first camera, mm; NaN exactly where not OK.
    sigma : (R, C, 3) float64
        Random part of the standard deviation of x, y, z, mm; NaN likewise.
    epipolar_px : (R, C) float64
        Distance of what the second camera saw from the line on which it must lie; finite for
        points that were lost because of it.
    zncc : (R, C) float64
    status : (R, C) uint8
    spacing, subset_size : int
        px of the first picture.
    smoothed_px : float or None
        Root mean square by which smoothing moved the points, px; None without.
    """

    rig: Rig
    first_px: Floats
    second_px: Floats
    points: Floats
    sigma: Floats
    epipolar_px: Floats
    zncc: Floats
    status: Codes
    spacing: int
    subset_size: int
    smoothed_px: float | None = None

    def __post_init__(self) -> None:
        lost = ~np.isfinite(self.points).all(axis=-1)
        if not np.array_equal(lost, self.status != PointStatus.OK):
            raise DataError("points must be NaN exactly where status is not OK")
