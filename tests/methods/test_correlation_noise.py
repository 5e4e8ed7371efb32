"""Predicted random errors against errors that were made."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import gaussian_filter

from shapemorph.core.image import GreyImage
from shapemorph.core.status import PointStatus
from shapemorph.methods.correlation_noise import (
    displacement_covariance,
    fitted_overlap,
    short_lags,
)
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import (
    SubsetSettings,
    grid_points,
    identity_starts,
    match_points,
)

SHAPE = (170, 210)
SHIFT = np.array([0.3, -0.4])


def _errors(pattern, pixels, settings, blur, seed, exposure=(2, lambda grey: grey)):
    """Errors of independent points and their predicted standard deviations."""
    rng, (level, light) = np.random.default_rng(seed), exposure
    noise = rng.normal(0, level / 255, (2, *SHAPE))
    if blur:
        noise[1] = gaussian_filter(noise[1], blur)
        noise[1] *= 2 / 255 / noise[1].std()
    full = np.ones(SHAPE, dtype=bool)
    pictures = [pattern(pixels) + noise[0], light(pattern(pixels - SHIFT)) + noise[1]]
    first, second = (GreyImage(picture.astype("f4"), full) for picture in pictures)
    pad, degree = settings.pad, settings.degree
    reference = prepare_reference(first, allowed=None, pad=pad, degree=degree)
    deformed = prepare_deformed(second, pad=pad, degree=degree)
    grid = grid_points(full, spacing=16)
    points = grid.points[1:-1, 1:-1]
    flat = points.reshape(-1, 2)
    found = match_points(reference, deformed, flat, identity_starts(len(flat)), settings=settings)
    ok = (found.status == PointStatus.OK).reshape(points.shape[:2])
    covariance = displacement_covariance(
        reference, deformed, points, found.warps.reshape(*ok.shape, 12), ok, settings=settings
    )
    error = (found.position - flat - SHIFT).reshape(points.shape)
    return error[ok], np.sqrt(covariance[..., [0, 1], [0, 1]])[ok]


@pytest.mark.parametrize(
    ("order", "blur", "degree"),
    [(1, 0.0, 3), (1, 1.0, 3), (2, 0.0, 3), (0, 0.0, 3), (1, 0.0, 5)],
)
def test_sigma_is_the_scatter_of_the_errors(order, blur, degree, wave_pattern, pixel_grid):
    pattern, pixels = wave_pattern(), pixel_grid(SHAPE)
    settings = SubsetSettings(9, order, 1e-3, 30, 0.5, 9.0, degree)
    runs = [_errors(pattern, pixels, settings, blur, seed) for seed in range(4)]
    error, sigma = (np.concatenate(parts) for parts in zip(*runs, strict=True))
    ratio = np.sqrt((error**2).mean()) / np.sqrt((sigma**2).mean())
    assert ratio == pytest.approx(1.0, abs=0.1)  # of some 700 components: 3 % by chance
    assert 0.60 < (np.abs(error) <= sigma).mean() < 0.76


@pytest.mark.parametrize(
    ("level", "size", "slope"),
    [(1, 21, 0.0), (2, 15, 0.0), (2, 31, 0.0), (5, 21, 0.0), (5, 15, 0.02), (2, 21, 0.02)],
)
def test_two_thirds_of_the_errors_are_within_sigma(level, size, slope, wave_pattern, pixel_grid):
    pattern, pixels = wave_pattern(), pixel_grid(SHAPE)
    settings = SubsetSettings(size // 2, 1, 1e-3, 30, 0.5, 9.0)
    across = slope * (pixels[..., 0] / SHAPE[1] - 0.5)

    def light(grey):
        return 0.9 * grey + 0.03 + across

    runs = [_errors(pattern, pixels, settings, 0.0, seed, (level, light)) for seed in range(6)]
    error, sigma = (np.concatenate(parts) for parts in zip(*runs, strict=True))
    assert 0.63 < (np.abs(error) <= sigma).mean() < 0.73


def test_noise_twice_as_strong_doubles_sigma(wave_pattern, pixel_grid):
    pattern, pixels = wave_pattern(), pixel_grid(SHAPE)
    settings = SubsetSettings(9, 1, 1e-3, 30, 0.5, 9.0)
    _, quiet = _errors(pattern, pixels, settings, 0.0, 0)
    _, loud = _errors(lambda p: 0.5 * pattern(p) + 0.25, pixels, settings, 0.0, 0)
    assert np.median(loud / quiet) == pytest.approx(2.0, rel=0.05)


def test_lost_points_have_no_sigma(wave_pattern, pixel_grid):
    pattern, pixels = wave_pattern(), pixel_grid((90, 90))
    full = np.ones((90, 90), dtype=bool)
    picture = GreyImage(pattern(pixels).astype("f4"), full)
    settings = SubsetSettings(7, 1, 1e-3, 30, 0.5, 7.0)
    reference = prepare_reference(picture, allowed=None, pad=settings.pad)
    points = grid_points(full, spacing=20).points[1:-1, 1:-1]
    usable = np.ones(points.shape[:2], dtype=bool)
    usable[0, 1] = False
    found = displacement_covariance(
        reference,
        prepare_deformed(picture, pad=settings.pad),
        points,
        identity_starts(usable.size).reshape(*usable.shape, 12),
        usable,
        settings=settings,
    )
    assert np.isnan(found[0, 1]).all()
    assert np.isfinite(found[usable]).all()


def test_one_lag_of_each_opposite_pair():
    lags = short_lags(2)
    assert len(lags) == 13
    assert lags[0].tolist() == [0, 0]
    assert not {tuple(lag) for lag in lags[1:]} & {tuple(-lag) for lag in lags[1:]}


def test_the_projector_has_as_many_dimensions_as_images_are_fitted(wave_pattern, pixel_grid):
    picture = GreyImage(wave_pattern()(pixel_grid((60, 60))).astype("f4"), np.ones((60, 60), bool))
    reference = prepare_reference(picture, allowed=None, pad=4)
    points = np.array([[30, 32], [40, 28]])
    overlap = fitted_overlap(reference, points, radius=9, order=1, reach=3)
    assert_allclose(overlap[3, 3] * 19 * 19, 10.0, rtol=1e-9)  # gain, offset, 2 light, 6 motion
    assert_allclose(overlap, overlap[::-1, ::-1], atol=1e-12)
