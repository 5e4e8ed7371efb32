"""Figures of pictures that are known in closed form."""

import numpy as np
import pytest

from shapemorph.core.image import GreyImage
from shapemorph.methods.picture_quality import picture_quality, predicted_sigma

HEIGHT, WIDTH = 121, 160
AMPLITUDE, WAVE = 0.2, 2 * np.pi / 16


def waves(noise=0.0):
    x = np.arange(WIDTH) * np.ones((HEIGHT, 1))
    grey = 0.5 + AMPLITUDE * np.sin(WAVE * x)
    grey += np.random.default_rng(0).normal(0, noise, grey.shape)
    return GreyImage(grey.astype(np.float32), np.ones(grey.shape, dtype=bool))


def test_a_wave_has_the_gradient_of_the_closed_form():
    found = picture_quality(waves(), subset_size=16, noise=0.0)
    slope = 255 * AMPLITUDE * np.sin(WAVE)  # of central differences
    assert found.contrast == pytest.approx(255 * AMPLITUDE / np.sqrt(2), rel=1e-3)
    assert found.mean_grey == pytest.approx(127.5, abs=0.01)
    assert found.mean_gradient == pytest.approx(slope * 2 / np.pi, rel=0.02)
    assert found.sssig_x == pytest.approx(16 * 16 * slope**2 / 2, rel=1e-3)
    assert found.sssig_y == pytest.approx(0.0, abs=1e-3)
    assert found.sssig_poor == pytest.approx(0.0, abs=1e-3)
    assert found.clipped_share == 0.0


def test_noise_does_not_count_as_pattern():
    clean = picture_quality(waves(), subset_size=16, noise=0.0)
    noisy = picture_quality(waves(5 / 255), subset_size=16, noise=5.0)
    assert noisy.sssig_x == pytest.approx(clean.sssig_x, rel=0.02)
    assert noisy.sssig_y < 0.02 * clean.sssig_x


def test_only_the_mask_counts_and_clipped_pixels_are_seen():
    picture = waves()
    picture.grey[:, :80] = 0.0
    picture.mask[:, :80] = False
    assert picture_quality(picture, subset_size=15, noise=0.0).clipped_share == 0.0
    picture.mask[:] = True
    assert picture_quality(picture, subset_size=15, noise=0.0).clipped_share == 0.5


def test_a_picture_smaller_than_a_subset_has_no_sums():
    assert np.isnan(picture_quality(waves(), subset_size=151, noise=0.0).sssig_x)


def test_the_prediction_is_that_of_the_formula():
    assert predicted_sigma(2.0, 32.0) == pytest.approx(np.sqrt(2) * 2 / np.sqrt(32))
    assert np.isnan(predicted_sigma(2.0, 0.0))
