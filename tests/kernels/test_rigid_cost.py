import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapemorph.kernels.rigid_cost import clipped_misfits


def test_misfits_are_squared_distances_up_to_the_most():
    rng = np.random.default_rng(4)
    source, target = rng.normal(size=(30, 3)), rng.normal(size=(30, 3))
    turns, shifts = Rotation.random(5, random_state=1).as_matrix(), rng.normal(size=(5, 3))
    found = clipped_misfits(source, target, turns, shifts, 2.5)
    for turn, shift, value in zip(turns, shifts, found, strict=True):
        distance = np.linalg.norm(source @ turn.T + shift - target, axis=1)
        assert value == pytest.approx(np.minimum(distance**2, 2.5).sum())


def test_the_motion_itself_leaves_nothing():
    source = np.random.default_rng(5).normal(size=(50, 3))
    turn, shift = Rotation.from_rotvec([0.1, -0.4, 1.0]).as_matrix(), np.array([3.0, -2.0, 0.5])
    target = source @ turn.T + shift
    assert clipped_misfits(source, target, turn[None], shift[None], 1.0)[0] < 1e-28
