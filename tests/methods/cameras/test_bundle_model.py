import numpy as np

from shapemorph.methods.cameras.bundle_model import (
    Arrangement,
    moved,
    observations_of,
    residuals_of,
    slopes_of,
)


def test_analytic_slopes_agree_with_differences(stereo_pair, twenty_views):
    sightings, views, poses = twenty_views
    seen, at = observations_of(sightings, views), Arrangement(stereo_pair, tuple(poses))
    by_camera, by_view = slopes_of(seen, at)
    still = np.zeros(2 * 16), np.zeros((20, 6))
    for which, slopes in enumerate((by_camera, by_view)):
        for k in range(slopes.shape[-1]):
            steps = [part.copy() for part in still]
            steps[which].reshape(-1, slopes.shape[-1])[:, k] = 1e-6
            ahead = residuals_of(seen, moved(at, *steps))
            behind = residuals_of(seen, moved(at, *(-step for step in steps)))
            scale = np.abs(slopes[:, :, k]).max()
            np.testing.assert_allclose((behind - ahead) / 2e-6, slopes[:, :, k], atol=3e-5 * scale)
