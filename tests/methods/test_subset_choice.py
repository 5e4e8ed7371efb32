"""Subset size and spacing follow the pattern and its noise."""

import numpy as np
import pytest

from shapemorph.core.image import GreyImage
from shapemorph.methods.subset_choice import (
    choose_subset,
    finest_subset,
    grey_noise,
    settled_sizes,
)

SHAPE = (200, 260)


@pytest.fixture
def picture(wave_pattern, pixel_grid):
    """Make a picture of a pattern with noise and contrast."""

    def make(size=5.0, noise=0.0, contrast=1.0):
        grey = 0.5 + contrast * (wave_pattern(size)(pixel_grid(SHAPE)) - 0.5)
        grey += np.random.default_rng(1).normal(0, noise, SHAPE)
        return GreyImage(grey.astype("f4"), np.ones(SHAPE, dtype=bool))

    return make


def _choose(picture, subset_size=None, spacing=None):
    return choose_subset(picture, subset_size=subset_size, spacing=spacing)


def test_about_four_speckles_and_a_quarter_of_it_apart(picture):
    choice = _choose(picture(5.0, noise=2 / 255))
    assert 3.5 < choice.subset_size / choice.speckle_px < 4.5
    assert choice.subset_size % 2 == 1
    assert choice.spacing == round(choice.subset_size / 4)
    assert "speckles" in choice.reason


def test_a_coarser_pattern_takes_a_larger_subset(picture):
    assert _choose(picture(9.0)).subset_size > 1.5 * _choose(picture(5.0)).subset_size


def test_noise_takes_a_larger_subset_up_to_a_limit(picture):
    quiet, noisy = _choose(picture(noise=0.002)), _choose(picture(noise=0.03, contrast=0.4))
    assert noisy.subset_size > quiet.subset_size
    assert "noise" in noisy.reason
    assert _choose(picture(noise=0.2, contrast=0.1)).subset_size <= 61


def test_what_is_configured_is_kept(picture):
    choice = _choose(picture(), subset_size=33, spacing=7)
    assert (choice.subset_size, choice.spacing) == (33, 7)
    assert "configured" in choice.reason


def test_only_what_is_missing_is_chosen(picture, monkeypatch):
    image = picture()
    choice = _choose(image, subset_size=33)
    assert settled_sizes(image, subset_size=33, spacing=None) == (33, choice.spacing)
    monkeypatch.setattr("shapemorph.methods.subset_choice._pattern", None)  # cannot be measured
    assert settled_sizes(image, subset_size=33, spacing=7) == (33, 7)


def test_a_picture_without_pattern_still_gets_an_answer():
    blank = GreyImage(np.full((80, 80), 0.5, dtype="f4"), np.ones((80, 80), dtype=bool))
    choice = _choose(blank)
    assert choice.subset_size >= 15
    assert "no speckle" in choice.reason


@pytest.mark.parametrize("noise", [0.004, 0.02])
def test_noise_is_measured(noise, picture):
    assert grey_noise(picture(5.0, noise=noise)) == pytest.approx(noise, rel=0.15)


def test_noise_outside_the_mask_does_not_count(picture):
    clean = picture(5.0, noise=0.004)
    mask = clean.mask.copy()
    mask[:, 130:] = False
    loud = clean.grey + np.where(mask, 0, np.random.default_rng(2).normal(0, 0.5, SHAPE))
    found = grey_noise(GreyImage(loud.astype("f4"), mask))
    assert found == pytest.approx(0.004, rel=0.2)


def test_the_finest_subset_still_shows_the_pattern_and_bears_the_noise(picture):
    fine, coarse = picture(5.0), picture(12.0)
    assert 15 <= finest_subset(fine, order=1) < _choose(fine).subset_size
    assert (
        finest_subset(coarse, order=1)
        > 2 * choose_subset(coarse, subset_size=None, spacing=None).speckle_px
    )
    noisy = picture(5.0, noise=0.03, contrast=0.5)
    assert finest_subset(noisy, order=2) > finest_subset(noisy, order=1)
