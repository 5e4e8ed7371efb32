"""A stereo rig and targets that are known exactly."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapemorph.core.calibration import Sighting, Target, View
from shapemorph.core.camera import Camera
from shapemorph.core.transform import RigidTransform

SIZE = (2352, 1728)


@pytest.fixture(scope="session")
def stereo_pair() -> tuple[Camera, Camera]:
    """Two cameras 20 degrees apart that look at a point 430 mm away."""
    turn = Rotation.from_euler("y", 20, degrees=True).as_matrix()
    there = np.array([0.0, 0.0, 430.0])
    left = Camera(
        SIZE,
        np.array([9000.0, 9010.0]),
        np.array([1180.0, 860.0]),
        radial=np.array([-0.12, 0.3, 1.0]),
    )
    right = Camera(
        SIZE,
        np.array([8950.0, 8960.0]),
        np.array([1170.0, 870.0]),
        radial=np.array([-0.1, 0.2, 2.0]),
        pose=RigidTransform(turn, there - turn @ there),
    )
    return left, right


@pytest.fixture(scope="session")
def board() -> Target:
    """A board of 11 x 8 points, 8 mm apart."""
    grid = np.stack(np.meshgrid(np.arange(11), np.arange(8)), axis=-1).reshape(-1, 2) * 8.0
    return Target("board", np.column_stack([grid - grid.mean(axis=0), np.zeros(len(grid))]))


@pytest.fixture(scope="session")
def board_poses():
    """Make places of a board in front of the rig, tilted up to half a radian."""

    def make(count: int) -> list[RigidTransform]:
        rng = np.random.default_rng(0)
        return [
            RigidTransform(
                Rotation.from_rotvec(rng.uniform(-0.5, 0.5, 3)).as_matrix(),
                np.array([*rng.uniform(-12, 12, 2), 430 + rng.uniform(-20, 20)]),
            )
            for _ in range(count)
        ]

    return make


@pytest.fixture(scope="session")
def twenty_views(stereo_pair, board, board_poses):
    """Sightings without noise, views and poses of a calibration with 20 pictures a camera."""
    poses = board_poses(20)
    views = [View(f"view {k}", board) for k in range(20)]
    sightings = [
        Sighting(c, k, np.arange(len(board.points)), camera.project(pose.apply(board.points)))
        for k, pose in enumerate(poses)
        for c, camera in enumerate(stereo_pair)
    ]
    return sightings, views, poses


@pytest.fixture(scope="session")
def noisy():
    """Add normal noise to sightings."""

    def add(sightings, sigma, seed):
        rng = np.random.default_rng(seed)
        return [
            Sighting(s.camera, s.view, s.ids, s.pixels + rng.normal(0, sigma, s.pixels.shape))
            for s in sightings
        ]

    return add
