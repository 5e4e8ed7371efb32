import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapemorph.core.calibration import Sighting, Target, View
from shapemorph.core.errors import StageError
from shapemorph.methods.cameras.bundle import adjust, free_lens
from shapemorph.methods.cameras.bundle_model import (
    Arrangement,
    Observations,
    moved,
    moved_pose,
    observations_of,
)

LENS = free_lens(radial=3, tangential=False, skew=False)


@pytest.fixture(scope="module")
def exact(stereo_pair, twenty_views):
    sightings, views, poses = twenty_views
    return observations_of(sightings, views), Arrangement(stereo_pair, tuple(poses))


def test_exact_points_lead_back_to_the_cameras(exact):
    seen, truth = exact
    off = np.tile([30.0, -25, 8, -6, 0.02, -0.1, 1, 0, 0, 0] + [0.003] * 3 + [2.0] * 3, 2)
    off[10:16] = 0
    start = moved(truth, off, np.full((20, 6), 0.01))
    found = adjust(seen, start, lens=LENS, fixed=0, cauchy=None)
    assert np.abs(found.residuals).max() < 1e-6
    for one, other in zip(found.arrangement.cameras, truth.cameras, strict=True):
        np.testing.assert_allclose(one.focal, other.focal, rtol=1e-8)
        np.testing.assert_allclose(one.pose.translation, other.pose.translation, atol=1e-5)


def deviations(found, truth):
    """Errors of all free unknowns of both cameras over their standard deviations."""
    errors = []
    for one, other in zip(found.arrangement.cameras, truth.cameras, strict=True):
        turn = Rotation.from_matrix(one.pose.rotation @ other.pose.rotation.T).as_rotvec()
        errors += [*(one.focal - other.focal), *(one.centre - other.centre)]
        errors += [*(one.radial - other.radial), 0, 0, 0, *turn]
        errors += [*(one.pose.translation - other.pose.translation)]
    sigma = np.sqrt(np.diag(found.covariance))
    return np.array(errors)[sigma > 0] / sigma[sigma > 0]


def test_standard_deviations_tell_the_errors_of_fifty_noise_draws(exact):
    seen, truth = exact
    rng = np.random.default_rng(1)
    scores = []
    for _ in range(50):
        pixel = seen.pixel + rng.normal(0, 0.1, seen.pixel.shape)
        noisy = Observations(seen.camera, seen.view, seen.point, seen.normal, seen.radius, pixel)
        found = adjust(noisy, truth, lens=LENS, fixed=0, cauchy=None)
        scores.append(deviations(found, truth))
    scores = np.abs(scores)
    assert scores.shape == (50, 20)
    assert (scores < 3).mean() >= 0.99
    assert 0.63 <= (scores < 1).mean() <= 0.73


def test_pictures_that_do_not_settle_the_lens_are_refused(stereo_pair):
    line = Target("line", np.column_stack([np.arange(8.0), np.zeros(8), np.zeros(8)]))
    camera = stereo_pair[0]
    pose = moved_pose(camera.pose, np.array([0, 0, 0, 0, 0, 400.0]))
    seen = Sighting(0, 0, np.arange(8), camera.project(pose.apply(line.points)))
    observed = observations_of([seen], [View("one", line)])
    with pytest.raises(StageError, match="do not settle"):
        adjust(observed, Arrangement((camera,), (pose,)), lens=LENS, fixed=0, cauchy=None)
