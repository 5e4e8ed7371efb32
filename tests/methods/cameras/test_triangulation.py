import numpy as np

from shapemorph.methods.cameras.triangulation import pixel_slopes, triangulate


def points_near(count=200):
    return np.random.default_rng(0).uniform(-25, 25, (count, 3)) + np.array([0, 0, 430.0])


def test_exact_pixels_lead_back_to_the_points(stereo_pair):
    points = points_near()
    pixels = np.stack([camera.project(points) for camera in stereo_pair])
    found = triangulate(stereo_pair, pixels, np.full(pixels.shape, 0.1))
    np.testing.assert_allclose(found.points, points, atol=1e-8)
    assert found.epipolar_error.max() < 1e-8


def test_standard_deviations_tell_the_errors(stereo_pair):
    points = points_near(4000)
    pixels = np.stack([camera.project(points) for camera in stereo_pair])
    sigma = np.stack([np.full((4000, 2), 0.02), np.full((4000, 2), 0.05)])
    pixels += np.random.default_rng(1).normal(0, 1, pixels.shape) * sigma
    found = triangulate(stereo_pair, pixels, sigma)
    share = (np.abs(found.points - points) < found.sigma).mean(axis=0)
    assert ((share > 0.65) & (share < 0.715)).all()


def test_what_one_camera_did_not_see_has_no_place(stereo_pair):
    points = points_near(3)
    pixels = np.stack([camera.project(points) for camera in stereo_pair])
    pixels[1, 1] = np.nan
    found = triangulate(stereo_pair, pixels, np.full(pixels.shape, 0.1))
    assert np.isfinite(found.points[[0, 2]]).all()
    assert np.isnan(found.points[1]).all()
    assert np.isnan(found.sigma[1]).all()


def test_slopes_are_derivatives(stereo_pair):
    points = points_near(5)
    for k in range(3):
        step = np.zeros(3)
        step[k] = 1e-4
        for camera in stereo_pair:
            numeric = (camera.project(points + step) - camera.project(points - step)) / 2e-4
            np.testing.assert_allclose(
                pixel_slopes(camera, points)[:, :, k], numeric, rtol=1e-5, atol=1e-6
            )
