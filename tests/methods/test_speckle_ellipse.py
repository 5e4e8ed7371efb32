import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import gaussian_filter

from shapemorph.methods.contrast import Pattern
from shapemorph.methods.speckle_ellipse import erode, measure_speckle


def gaussian_pattern(std, angle=0.0, ratio=1.0, shape=(360, 420), seed=0):
    """White noise blurred by an elliptic Gaussian: its speckle covariance is exactly known."""
    rows, cols = (np.fft.fftfreq(n) * 2 * np.pi for n in shape)
    ky, kx = np.meshgrid(rows, cols, indexing="ij")
    axis = np.array([np.cos(angle), np.sin(angle)])
    along = kx * axis[0] + ky * axis[1]
    across = -kx * axis[1] + ky * axis[0]
    long, short = std * np.sqrt(ratio), std / np.sqrt(ratio)
    transfer = np.exp(-0.5 * ((long * along) ** 2 + (short * across) ** 2))
    noise = np.random.default_rng(seed).normal(size=shape)
    values = np.fft.ifft2(np.fft.fft2(noise) * transfer).real
    covariance = long**2 * np.outer(axis, axis)
    covariance += short**2 * (np.eye(2) - np.outer(axis, axis))
    return Pattern(
        (values / values.std()).astype(np.float32), np.ones(shape, bool), 0.2
    ), covariance


def exponential(logarithm):
    eigenvalues, axes = np.linalg.eigh(logarithm)
    return (axes * np.exp(eigenvalues)) @ axes.T


@pytest.mark.parametrize("std", [1.2, 2.0, 4.0])
@pytest.mark.parametrize(("angle", "ratio"), [(0.0, 1.0), (0.5, 2.0), (2.0, 4.0)])
def test_covariance_of_an_elliptic_speckle(std, angle, ratio):
    std = max(std, 0.7 * np.sqrt(ratio))  # pixels must resolve the short axis
    pattern, expected = gaussian_pattern(std, angle, ratio)
    field = measure_speckle(pattern, window=150)
    measured = exponential(field.median)
    # a window holds (150 / 6 std)^2 speckles, about the square root of which is seen here;
    # the derivative operator is corrected to first order only
    assert_allclose(measured, expected, atol=0.15 * np.abs(expected).max())
    assert_allclose(field.std, std, rtol=0.05)


def test_field_follows_a_stretch_that_varies():
    fine, _ = gaussian_pattern(1.5)
    coarse, _ = gaussian_pattern(3.0, seed=1)
    values = np.where(np.arange(420) < 210, fine.values, coarse.values)
    field = measure_speckle(Pattern(values, fine.mask, 0.2), window=80)
    left = field.mean_over(np.array([20.0, 0.0]), np.array([140.0, 359.0]))
    right = field.mean_over(np.array([280.0, 0.0]), np.array([400.0, 359.0]))
    assert_allclose(np.exp(np.trace(left) / 4), 1.5, rtol=0.1)
    assert_allclose(np.exp(np.trace(right) / 4), 3.0, rtol=0.1)


def test_rim_of_the_mask_does_not_look_like_pattern():
    pattern, _ = gaussian_pattern(2.0, shape=(300, 300))
    rows, cols = np.mgrid[:300, :300]
    mask = (rows - 150) ** 2 + (cols - 140) ** 2 < 90**2
    masked = Pattern(np.where(mask, pattern.values, 5.0).astype(np.float32), mask, 0.2)
    field = measure_speckle(masked, window=80)
    assert 0.1 < field.trusted.mean() < 0.6
    assert_allclose(field.std, 2.0, rtol=0.1)
    assert np.isfinite(field.log_covariance).all()


def test_blank_pattern_has_no_speckle():
    nothing = np.zeros((100, 100), np.float32)
    assert measure_speckle(Pattern(nothing, nothing == 0, 0.0), window=60) is None
    assert measure_speckle(Pattern(nothing, nothing > 0, 0.0), window=60) is None


def test_erosion_takes_a_margin_off_mask_and_picture():
    mask = np.ones((9, 12), bool)
    mask[:, 9:] = False
    kept = erode(mask, 2)
    assert kept[2:7, 2:7].all()
    assert kept.sum() == 25


def test_blurred_noise_is_what_the_oracle_says():
    # the same pattern by scipy: guards the test's own Fourier filter
    pattern, _ = gaussian_pattern(2.0)
    noise = np.random.default_rng(0).normal(size=(360, 420))
    expected = gaussian_filter(noise, 2.0, mode="wrap", truncate=6)
    assert_allclose(pattern.values, expected / expected.std(), atol=1e-3)
