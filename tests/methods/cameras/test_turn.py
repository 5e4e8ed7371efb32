from dataclasses import replace

import numpy as np
import pytest

from shapemorph.core.camera import Camera, Rig
from shapemorph.core.image import GreyImage
from shapemorph.core.reconstruction import Reconstruction
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.cameras.averaged_grey import Photograph, average_grey
from shapemorph.methods.cameras.turn import merge, pair_up


def camera_at(degrees):
    turn = np.radians(degrees)
    rotation = np.array(
        [[np.cos(turn), 0, -np.sin(turn)], [0, 1, 0], [np.sin(turn), 0, np.cos(turn)]]
    )
    pose = RigidTransform(rotation, np.array([0.0, 0.0, 200.0]))
    return Camera((200, 200), np.full(2, 800.0), np.full(2, 99.5), pose=pose)


def test_pairs_are_those_about_the_angle_apart():
    cameras = [camera_at(10 * k) for k in range(36)]
    pairs = pair_up(cameras, angle=np.radians(20), patches=None)
    assert len(pairs) == 36
    assert all((b - a) % 36 == 2 for a, b in pairs)
    assert len(pair_up(cameras, angle=np.radians(20), patches=12)) == 12
    few = [camera_at(10 * k) for k in range(4)]
    assert pair_up(few, angle=np.radians(20), patches=None) == [(0, 2), (1, 3)]
    assert pair_up(few, angle=np.radians(90), patches=None) == []


def patch(camera, low, high, noise, seed):
    """A grid on the plane z = 0.1 x that one camera saw."""
    x, y = np.meshgrid(np.arange(low, high, 1.0), np.arange(-10, 10, 1.0))
    rng = np.random.default_rng(seed)
    points = np.stack([x, y, 0.1 * x + rng.normal(0, noise, x.shape)], axis=-1)
    shape = x.shape
    pixels = np.zeros((*shape, 2))
    rest = np.zeros(shape)
    rig = Rig((camera, camera), ("a", "b"))
    return Reconstruction(
        rig, pixels, pixels, points, points, rest, rest, rest.astype(np.uint8), 5, 21
    )


def test_patches_become_one_cloud_without_doubles():
    noise = 0.02
    parts = [patch(camera_at(5 * k), 8 * k, 8 * k + 14, noise, k) for k in range(3)]
    found = merge(parts)
    assert len(found.points) == 30 * 20
    assert 0.8 * noise < found.overlap_rms < 1.5 * noise
    off = (found.points[:, 2] - 0.1 * found.points[:, 0]) / np.hypot(1, 0.1)
    assert off.std() < 0.75 * noise
    np.testing.assert_allclose(np.linalg.norm(found.towards, axis=1), 1.0)


def test_one_patch_alone_overlaps_nothing():
    assert np.isnan(merge([patch(camera_at(0), 0, 9, 0.0, 0)]).overlap_rms)


def test_merging_keeps_curvature():
    """A ball of 25 mm: planes through the neighbours would cut its radius by 0.05 mm."""
    cap = patch(camera_at(0), -8, 8, 0.0, 0)
    ball = cap.points.copy()
    ball[..., 2] = -np.sqrt(625 - (ball[..., :2] ** 2).sum(axis=-1))
    found = merge([replace(cap, points=ball)])
    radius = np.linalg.norm(found.points, axis=1)
    assert np.abs(radius - 25).mean() < 1e-3


def picture(grey, mask=True):
    return GreyImage(np.full((200, 200), grey, np.float32), np.full((200, 200), mask))


@pytest.fixture
def point():
    return np.array([[0.0, 0.0, 0.0]]), np.array([[0.0, 0.0, -1.0]])


def test_views_are_weighed_by_how_directly_they_look(point):
    shots = [Photograph(camera_at(0), picture(0.2)), Photograph(camera_at(60), picture(0.6))]
    grey, weight = average_grey(*point, shots)
    assert grey[0] == pytest.approx((0.2 * 1 + 0.6 * 0.25) / 1.25, abs=1e-6)
    assert weight[0] == pytest.approx(1.25)


def test_glare_does_not_count_unless_all_is_glare(point):
    shots = [Photograph(camera_at(0), picture(1.0)), Photograph(camera_at(40), picture(0.4))]
    assert average_grey(*point, shots)[0][0] == pytest.approx(0.4, abs=1e-6)
    assert average_grey(*point, shots[:1])[0][0] == pytest.approx(1.0, abs=1e-6)


def test_what_no_view_shows_is_unknown(point):
    behind = Photograph(camera_at(180), picture(0.5))
    masked = Photograph(camera_at(0), picture(0.5, mask=False))
    assert np.isnan(average_grey(*point, [behind, masked])[0][0])


def test_a_patch_that_glare_bent_does_not_move_the_others():
    parts = [patch(camera_at(5 * k), 0, 14, 0.01, k) for k in range(5)]
    bent = parts[0].points.copy()
    bent[6:14, 5:9, 2] += 0.5
    found = merge([replace(parts[0], points=bent), *parts[1:]])
    off = (found.points[:, 2] - 0.1 * found.points[:, 0]) / np.hypot(1, 0.1)
    assert np.abs(off).max() < 0.03
