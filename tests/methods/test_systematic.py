"""Estimated systematic errors against errors that were made."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import savgol_coeffs

from shapemorph.core.image import GreyImage
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import (
    SubsetSettings,
    affine_starts,
    grid_points,
    match_points,
)
from shapemorph.methods.systematic import interpolation_bias, pattern_spectrum, shape_bias

SHAPE = (150, 210)


def _matched(pictures, field, settings, spacing):
    """Grid of matches of points started from the truth rounded to a pixel, all of them."""
    full = np.ones(SHAPE, dtype=bool)
    still, moved = (GreyImage(grey.astype("f4"), full) for grey in pictures)
    pad, degree = settings.pad, settings.degree
    reference = prepare_reference(still, allowed=None, pad=pad, degree=degree)
    deformed = prepare_deformed(moved, pad=pad, degree=degree)
    points = grid_points(full, spacing=spacing).points
    points = points[2:-2, 2:-2]
    flat, truth = points.reshape(-1, 2), field(points.astype(np.float64))
    slopes = np.broadcast_to(np.eye(2), (len(flat), 2, 2))
    starts = affine_starts(flat, np.rint(truth).reshape(-1, 2), slopes)
    found = match_points(reference, deformed, flat, starts, settings=settings)
    usable = (found.status == 0).reshape(points.shape[:2])
    assert usable.mean() > 0.95
    position, gradient = found.position.reshape(points.shape), found.gradient
    return reference, points, position, gradient.reshape(*usable.shape, 2, 2), usable, truth


def _rms(values):
    return np.sqrt((values**2).mean())


@pytest.mark.parametrize(
    ("order", "period", "noise"), [(1, 90, 0), (1, 60, 2 / 255), (1, 130, 1 / 255)]
)
def test_the_bias_explains_what_a_shape_function_cannot_follow(
    order, period, noise, wave_pattern, pixel_grid
):
    pattern, pixels, rng = wave_pattern(), pixel_grid(SHAPE), np.random.default_rng(3)

    def field(at):
        return at + np.stack([np.sin(2 * np.pi * at[..., 0] / period), 0 * at[..., 0]], axis=-1)

    back = pixels.copy()
    for _ in range(60):
        back += pixels - field(back)
    pictures = [pattern(at) + rng.normal(0, noise, SHAPE) for at in (pixels, back)]
    settings = SubsetSettings(10, order, 1e-3, 50, 0.5, 10.0)
    _, _, position, _, usable, truth = _matched(pictures, field, settings, 6)
    bias = shape_bias(position, usable, spacing=6, radius=10, order=order)
    known = usable & np.isfinite(bias).all(axis=-1)
    assert known.sum() > 0.9 * usable.sum()
    error = (position - truth)[known]
    assert _rms(error[:, 0]) > 0.01
    assert _rms((error - bias[known])[:, 0]) < 0.5 * _rms(error[:, 0])
    assert _rms(bias[known][:, 1]) < 0.1 * _rms(bias[known][:, 0]) + 2 * noise


def test_a_field_that_the_shape_function_follows_has_no_bias():
    points = np.stack(np.meshgrid(np.arange(9) * 5.0, np.arange(8) * 5.0), axis=-1)
    x, y = points[..., 0], points[..., 1]
    usable = np.ones(x.shape, dtype=bool)
    usable[0, 0] = False
    linear = np.stack([1.1 * x + 0.2 * y + 3, 0.9 * y - 0.1 * x], axis=-1)
    bent = linear + 1e-3 * np.stack([x * x - x * y, y * y], axis=-1)
    for field, order in ((linear, 1), (bent, 2)):
        bias = shape_bias(field, usable, spacing=5, radius=10, order=order)
        assert_allclose(bias[usable], 0.0, atol=1e-9)
        assert np.isnan(bias[0, 0]).all()
    mean_square = 10 * 11 / 3  # of x over a subset of 21 px
    bias = shape_bias(bent, usable, spacing=5, radius=10, order=1)
    assert_allclose(bias[usable], 1e-3 * mean_square, rtol=1e-6)


def test_without_a_whole_window_there_is_no_estimate():
    points = np.stack(np.meshgrid(np.arange(4) * 5.0, np.arange(4) * 5.0), axis=-1)
    bias = shape_bias(points, np.ones((4, 4), dtype=bool), spacing=5, radius=10, order=1)
    assert np.isnan(bias).all()


@pytest.mark.parametrize(("degree", "least"), [(3, 1e-3), (5, 2e-4)])
def test_the_bias_between_pixels_is_that_of_fine_patterns(degree, least, wave_pattern, pixel_grid):
    pattern, pixels = wave_pattern(size=2.2), pixel_grid(SHAPE)
    settings = SubsetSettings(10, 1, 1e-4, 50, 0.5, 10.0, degree)
    made, told = [], []
    for shift in ([0.25, 0.0], [0.75, 0.25], [0.5, 0.6]):
        pictures = [pattern(pixels), pattern(pixels - shift)]
        reference, points, position, gradient, usable, truth = _matched(
            pictures, lambda at, s=shift: at + s, settings, 8
        )
        bias = interpolation_bias(reference, position - points, gradient, width=21)
        made.append((position - truth)[usable].mean(axis=0))
        told.append(bias[usable].mean(axis=0))
    made, told = np.array(made), np.array(told)
    assert least < np.abs(made).max() < 10 * least
    assert _rms(made - told) < 0.4 * _rms(made)


def test_noise_is_no_pattern(wave_pattern, pixel_grid):
    rng, full = np.random.default_rng(0), np.ones(SHAPE, dtype=bool)
    clean = wave_pattern()(pixel_grid(SHAPE))
    pictures = [GreyImage((clean + n).astype("f4"), full) for n in (0, rng.normal(0, 0.02, SHAPE))]
    quiet, noisy = (
        pattern_spectrum(prepare_reference(each, allowed=None, pad=20)) for each in pictures
    )
    assert noisy.sum() == pytest.approx(quiet.sum(), rel=0.05)


def test_a_mask_too_small_for_a_spectrum_has_no_interpolation_bias():
    mask = np.zeros(SHAPE, dtype=bool)
    mask[40:60, 40:60] = True
    picture = GreyImage(np.full(SHAPE, 0.5, dtype="f4"), mask)
    reference = prepare_reference(picture, allowed=None, pad=20)
    assert pattern_spectrum(reference) is None


def test_order_two_has_the_bias_of_a_savitzky_golay_filter():
    points = np.stack(np.meshgrid(np.arange(-4, 5) * 5.0, np.arange(-4, 5) * 5.0), axis=-1)
    field = points + 1e-6 * np.stack([points[..., 0] ** 4, points[..., 1] ** 4], axis=-1)
    bias = shape_bias(field, np.ones((9, 9), dtype=bool), spacing=5, radius=10, order=2)
    expected = 1e-6 * savgol_coeffs(21, 2, use="dot") @ np.arange(-10.0, 11.0) ** 4
    assert_allclose(bias[4, 4], expected, rtol=1e-6)
