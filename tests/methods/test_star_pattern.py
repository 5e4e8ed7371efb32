"""Spatial resolution against attenuations that are known."""

import numpy as np
import pytest

from shapemorph.methods.star_pattern import Star, spatial_resolution

STAR = Star(amplitude=0.5, shortest=10.0, longest=150.0, width=1000, row=250.0)


def test_the_period_grows_linearly():
    np.testing.assert_allclose(STAR.period(np.array([0.0, 999.0])), [10.0, 150.0])
    x = np.array([300.0, 700.0])
    np.testing.assert_allclose(STAR.displacement(x, np.full(2, 250.0)), 0.5)
    half = 250.0 + STAR.period(x) / 2
    np.testing.assert_allclose(STAR.displacement(x, half), -0.5)


@pytest.mark.parametrize("row", [250.0, 252.0])
def test_the_attenuation_of_a_moving_average_gives_its_period(row):
    x = np.arange(16, 985, 8).astype(float)
    period, width = STAR.period(x), 17
    kept = np.sin(np.pi * width / period) / (width * np.sin(np.pi / period))
    measured = kept * STAR.displacement(x, np.full(len(x), row))
    assert spatial_resolution(STAR, x, row, measured) == pytest.approx(67.8, abs=0.7)


def test_lost_points_are_left_out_and_too_few_give_nothing():
    x = np.arange(16, 985, 8).astype(float)
    measured = 0.5 * (1 - (20.0 / STAR.period(x)) ** 2)
    measured[::7] = np.nan
    assert spatial_resolution(STAR, x, 250.0, measured) == pytest.approx(63.2, abs=1.5)
    measured[10:] = np.nan
    assert np.isnan(spatial_resolution(STAR, x, 250.0, measured))


def test_what_is_never_resolved_has_no_resolution():
    x = np.arange(16, 985, 8).astype(float)
    assert np.isnan(spatial_resolution(STAR, x, 250.0, np.full(len(x), 0.2)))
