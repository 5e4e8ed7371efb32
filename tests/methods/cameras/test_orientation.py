import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapemorph.core.camera import Rig
from shapemorph.core.errors import StageError
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.cameras.orientation import epipolar_distance, orient


def matched(cameras, noise=0.0):
    rng = np.random.default_rng(0)
    points = rng.uniform(-25, 25, (800, 3)) + np.array([0, 0, 430.0])
    seen = [camera.project(points) for camera in cameras]
    return seen[0], seen[1] + rng.normal(0, noise, seen[1].shape)


def test_distance_from_the_epipolar_line(stereo_pair):
    """The cameras lie side by side: a shift down is nearly the whole distance."""
    seen, there = matched(stereo_pair)
    rig = Rig(stereo_pair, ("left", "right"))
    np.testing.assert_allclose(epipolar_distance(rig, seen, there), 0, atol=1e-8)
    off = epipolar_distance(rig, seen, there + np.array([0.0, 0.5]))
    np.testing.assert_allclose(off, 0.5, atol=0.01)


def test_a_moved_camera_is_found_again(stereo_pair):
    seen, there = matched(stereo_pair, noise=0.02)
    left, right = stereo_pair
    turn = Rotation.from_euler("xyz", [0.4, -9.0, 0.8], degrees=True).as_matrix()
    moved = right.placed(
        RigidTransform(turn @ right.pose.rotation, right.pose.translation + np.array([0, 3.0, 9.0]))
    )
    found = orient(left, moved, seen, there)
    angle = Rotation.from_matrix(found.rotation @ right.pose.rotation.T).magnitude()
    assert angle < 1e-3
    length = np.linalg.norm(moved.pose.translation)
    assert np.linalg.norm(found.translation) == pytest.approx(length)
    true = right.pose.translation / np.linalg.norm(right.pose.translation)
    assert np.linalg.norm(found.translation / length - true) < 5e-3
    rig = Rig((left, right.placed(found)), ("left", "right"))
    assert epipolar_distance(rig, seen, there).mean() < 0.03


def test_pixels_that_have_nothing_to_do_with_each_other_are_refused(stereo_pair):
    seen, there = matched(stereo_pair)
    shuffled = np.random.default_rng(1).permutation(there)
    with pytest.raises(StageError, match="do not tell how the cameras stand"):
        orient(*stereo_pair, seen, shuffled)
