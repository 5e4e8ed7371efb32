"""The rig of the synthetic experiments: two cameras, 70 mm lens, 225 mm apart, 20 degrees."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.camera import Camera, Rig
from shapemorph.core.transform import RigidTransform

SENSOR = (2352, 1728)  # px
BASELINE, ANGLE = 225.0, np.deg2rad(20.0)  # mm; between the axes
MM_PER_PX = 0.05  # where the axes meet
RADIAL = ((-0.10, 0.30, 0.0), (-0.12, 0.25, 0.0))
TANGENTIAL = ((2e-4, -3e-4), (-1e-4, 2e-4))
OFF_CENTRE = ((9.0, -14.0), (-12.0, 6.0))  # px: the principal points from the middle


def stereo_rig(*, scale: float, target: Floats) -> Rig:
    """Make two cameras that look at a point of the body from above.

    Parameters
    ----------
    scale : float
        Of the pictures; 1 is 2352 x 1728 px.
    target : (3,)
        Where both axes meet, mm; the cameras lie in the plane y = target[1], in +z.
    """
    distance = viewing_distance()
    focal = distance / MM_PER_PX * scale
    size = (round(SENSOR[0] * scale), round(SENSOR[1] * scale))
    cameras = []
    for k, side in enumerate((-1.0, 1.0)):
        lean = 0.5 * side * ANGLE
        forward = -np.array([np.sin(lean), 0.0, np.cos(lean)])
        down = np.array([0.0, -1.0, 0.0])
        rotation = np.stack([np.cross(down, forward), down, forward])
        place = target - distance * forward
        cameras.append(
            Camera(
                size=size,
                focal=np.full(2, focal),
                centre=(np.array(size) - 1) / 2 + scale * np.array(OFF_CENTRE[k]),
                radial=np.array(RADIAL[k]),
                tangential=np.array(TANGENTIAL[k]),
                pose=RigidTransform(rotation, -rotation @ place),
            )
        )
    return Rig(tuple(cameras), ("left", "right"))


def viewing_distance() -> float:
    """Distance from the cameras to where their axes meet, mm."""
    return float(0.5 * BASELINE / np.sin(0.5 * ANGLE))
