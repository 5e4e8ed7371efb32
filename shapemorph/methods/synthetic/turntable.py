"""A camera before a turntable that leans towards it, and the cone of dots that turns on it."""

import numpy as np
from scipy.spatial.transform import Rotation

from shapemorph.core.arrays import Floats
from shapemorph.core.calibration import Target
from shapemorph.core.camera import Camera
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.synthetic.stereo_rig import stereo_rig

LEAN = np.deg2rad(45.0)  # between the axis of the table and the line of sight
LOOKED_AT = -12.0  # mm above the flange, on the axis of the table: the middle of the picture
COLUMNS, ROWS = 36, 5
TOP, BELOW, PITCH = 4.0, 4.0, 5.0  # mm: of the cone, outside and below the rim; along its slope
DOT = 2.4  # mm, diameter
SLOPE = np.deg2rad(45.0)  # of the cone: its dots face a camera above
LEFT_OUT = {
    *((1, 1), (2, 4), (3, 6), (1, 8), (3, 11), (2, 13), (1, 16)),
    *((2, 18), (3, 20), (1, 23), (3, 25), (2, 28), (1, 30), (3, 33)),
}
"""Row and column of dots that are missing, so that every view tells where it is."""


def dotted_cone(rim: float) -> Target:
    """Make a cone of dots around and below a round part of radius `rim`, mm, about the axis z."""
    lattice = np.array(
        [(r, c) for r in range(ROWS) for c in range(COLUMNS) if (r, c) not in LEFT_OUT]
    )
    along = PITCH * lattice[:, 0]
    angle = 2 * np.pi * lattice[:, 1] / COLUMNS
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    out = rim + TOP + along * np.cos(SLOPE)
    points = np.column_stack([around * out[:, None], -BELOW - along * np.sin(SLOPE)])
    normals = np.column_stack([around * np.sin(SLOPE), np.full(len(points), np.cos(SLOPE))])
    return Target("cone", points, normals=normals, dot_radius=0.5 * DOT, lattice=lattice)


def turntable_camera(scale: float) -> Camera:
    """Give the first camera of the stereo rig, by itself: its frame is the world."""
    camera = stereo_rig(scale=scale, target=np.zeros(3)).cameras[0]
    return camera.placed(RigidTransform.identity())


def turntable_poses(camera: Camera, frames: int, distance: float) -> tuple[RigidTransform, ...]:
    """Place the part before the camera as the table turns by equal steps.

    Parameters
    ----------
    camera : Camera
    frames : int
    distance : float
        From the camera to the middle of the part, mm.

    Returns
    -------
    tuple of RigidTransform
        world_from_target; the axis z of the target is that of the table, and leans towards the
        camera.
    """
    upright = Rotation.from_euler("x", 180.0 - np.rad2deg(LEAN), degrees=True)
    poses = []
    for angle in 2 * np.pi * np.arange(frames) / frames:
        rotation = (upright * Rotation.from_euler("z", angle)).as_matrix()
        middle = rotation @ np.array([0.0, 0.0, LOOKED_AT])
        poses.append(RigidTransform(rotation, _ahead(camera, distance) - middle))
    return tuple(poses)


def _ahead(camera: Camera, distance: float) -> Floats:
    """Point (3,) that is seen in the middle of the picture."""
    x, y = camera.normalised((np.array(camera.size) - 1) / 2)
    ahead: Floats = distance * np.array([x, y, 1.0])
    return ahead
