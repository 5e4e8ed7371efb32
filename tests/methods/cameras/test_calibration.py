import numpy as np
import pytest

from shapemorph.core.calibration import Sighting, Target, View
from shapemorph.core.errors import DataError
from shapemorph.methods.cameras.bundle import free_lens
from shapemorph.methods.cameras.calibration import calibrate_rig

SIZE = (2352, 1728)
LENS = free_lens(radial=3, tangential=False, skew=False)


def calibrated(sightings, views, cameras=2, lens=LENS):
    names = ("left", "right", "top")[:cameras]
    return calibrate_rig(sightings, views, [SIZE] * cameras, names=names, lens=lens, rejected=())


def test_two_cameras_from_nothing_but_points(twenty_views, stereo_pair, noisy):
    sightings, views, _ = twenty_views
    found = calibrated(noisy(sightings, 0.1, 3), views)
    assert not found.rejected
    assert found.rms() == pytest.approx(0.1 * np.sqrt(2), rel=0.03)
    for one, other, sigma in zip(found.rig.cameras, stereo_pair, found.uncertainty, strict=True):
        assert (np.abs(one.focal - other.focal) < 4 * sigma.focal).all()
        assert (np.abs(one.centre - other.centre) < 4 * sigma.centre).all()
    true = np.linalg.norm(stereo_pair[1].position)
    assert found.rig.baseline(0, 1) == pytest.approx(true, rel=1e-3)
    assert not found.uncertainty[0].translation.any()


def test_one_camera(twenty_views, noisy):
    sightings, views, _ = twenty_views
    only = [seen for seen in noisy(sightings, 0.1, 4) if seen.camera == 0]
    found = calibrated(only, views, cameras=1)
    assert found.rms(camera=0) == pytest.approx(0.1 * np.sqrt(2), rel=0.05)


def test_three_cameras_tied_in_a_chain(twenty_views, stereo_pair, noisy):
    """The third camera shares views with the second only."""
    sightings, views, poses = twenty_views
    third = stereo_pair[1].placed(stereo_pair[1].pose.inverse())
    seen = [s for s in sightings if s.camera == 1 or s.view < 12]
    for k in range(12, 20):
        points = views[k].target.points
        seen.append(Sighting(2, k, np.arange(len(points)), third.project(poses[k].apply(points))))
    found = calibrated(noisy(seen, 0.05, 5), views, cameras=3)
    np.testing.assert_allclose(found.rig.cameras[2].position, third.position, atol=1.0)


def test_what_contradicts_is_put_aside_and_named(twenty_views, noisy):
    sightings, views, _ = twenty_views
    seen = noisy(sightings, 0.1, 6)
    seen[7] = Sighting(1, 3, seen[7].ids, seen[11].pixels)  # another moment
    seen[20] = Sighting(0, 10, seen[20].ids, seen[20].pixels + np.array([0.0, 2.0]))
    seen[30].pixels[5] += 9.0
    found = calibrated(seen, views)
    reasons = dict(found.rejected)
    assert "different places" in reasons["view 3 in right"]
    assert "contradicts" in reasons["view 10 in left"]
    assert set(reasons) == {"view 3 in right", "view 10 in left", "view 10 in right"}
    assert found.dropped_points == 1
    assert found.rms() == pytest.approx(0.1 * np.sqrt(2), rel=0.03)


def test_pictures_of_different_moments_are_refused(twenty_views):
    sightings, views, _ = twenty_views
    right = [s for s in sightings if s.camera == 1]
    shifted = [
        Sighting(1, s.view, s.ids, other.pixels)
        for s, other in zip(right, right[7:] + right[:7], strict=True)
    ]
    left = [s for s in sightings if s.camera == 0]
    with pytest.raises(DataError, match="contradict each other: of 20"):
        calibrated(left + shifted, views)


def test_cameras_without_a_common_view_are_refused(twenty_views):
    sightings, views, _ = twenty_views
    seen = [s for s in sightings if (s.view < 10) == (s.camera == 0)]
    with pytest.raises(DataError, match="right: no view ties it"):
        calibrated(seen, views)


def test_a_camera_that_saw_nothing_is_refused(twenty_views):
    sightings, views, _ = twenty_views
    with pytest.raises(DataError, match="right: no target was found"):
        calibrated([s for s in sightings if s.camera == 0], views)


def test_boards_seen_apart_are_tied_by_a_target_in_space(stereo_pair, twenty_views, noisy):
    sightings, _, poses = twenty_views
    rng = np.random.default_rng(2)
    solid = Target("solid", rng.uniform(-30, 30, (60, 3)))
    board = twenty_views[1][0].target
    views = [View(f"board {k}", board) for k in range(40)] + [View("solid", solid)]
    seen = [
        Sighting(s.camera, 2 * s.view + s.camera, s.ids, s.pixels) for s in sightings
    ]  # each camera sees its boards alone
    for c, camera in enumerate(stereo_pair):
        pixels = camera.project(poses[0].apply(solid.points))
        seen.append(Sighting(c, 40, np.arange(60), pixels))
    found = calibrated(noisy(seen, 0.05, 7), views)
    true = np.linalg.norm(stereo_pair[1].position)
    assert found.rig.baseline(0, 1) == pytest.approx(true, rel=1e-3)


def test_a_board_that_looks_the_same_turned_round_is_numbered_alike(twenty_views, board):
    sightings, _, _ = twenty_views
    half_turn = np.arange(len(board.points))[::-1].copy()
    even = Target("even", board.points, symmetries=(half_turn,))
    views = [View(f"view {k}", even) for k in range(20)]
    seen = [
        Sighting(s.camera, s.view, half_turn[s.ids], s.pixels)
        if s.camera == 1 and s.view % 3 == 0
        else s
        for s in sightings
    ]
    found = calibrated(seen, views)
    assert not found.rejected
    assert found.rms() < 1e-4
