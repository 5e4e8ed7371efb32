"""Cubic terms where a rim cuts a window."""

import numpy as np

from shapemorph.methods.grid_windows import connected_windows
from shapemorph.methods.quadratic_fit import quadratic_operators
from shapemorph.methods.rim_cubics import PointNoise, with_cubics

SPAN = np.arange(7.0) - 3
PLACES = np.stack(np.meshgrid(SPAN, SPAN), axis=-1).reshape(1, 49, 2) * 0.7


def one_sided(count=1):
    """Windows of which the points left of the centre are missing."""
    inside = np.repeat(PLACES[:, :, 0] >= 0, count, axis=0)
    return np.repeat(PLACES, count, axis=0), inside


def data_of(places, cubic):
    """Two components with known slopes 0.4, -0.2 and 1.1, 0.3 at the centre."""
    x, y = np.moveaxis(places, 2, 0)
    plain = np.stack([0.4 * x - 0.2 * y + 0.3 * x * y, 1.1 * x + 0.3 * y - 0.2 * x**2], axis=2)
    return plain + cubic * np.stack([x**3, x**2 * y - y**3], axis=2)


SLOPES = np.array([[0.4, 1.1], [-0.2, 0.3]])


def test_a_cubic_at_a_rim_is_followed_exactly_where_there_is_no_noise():
    places, inside = one_sided()
    data = data_of(places, 0.1)
    plain = quadratic_operators(places, inside)
    assert np.abs((plain @ data)[0, 1:3] - SLOPES).max() > 0.05
    noise = PointNoise(np.zeros((1, 49)), np.eye(49))
    found = with_cubics(places, inside, plain, data, noise)
    np.testing.assert_allclose((found @ data)[0, 1:3], SLOPES, atol=1e-12)


def test_terms_below_their_noise_are_left_out():
    places, inside = one_sided()
    data = data_of(places, 1e-4)
    plain = quadratic_operators(places, inside)
    noise = PointNoise(np.where(inside, 0.05, 0.0), np.eye(49))
    np.testing.assert_array_equal(with_cubics(places, inside, plain, data, noise), plain)


def test_between_both_the_share_grows_with_what_the_terms_say():
    places, inside = one_sided()
    plain = quadratic_operators(places, inside)
    exact = PointNoise(np.zeros((1, 49)), np.eye(49))
    noise = PointNoise(np.where(inside, 0.01, 0.0), np.eye(49))
    full = with_cubics(places, inside, plain, data_of(places, 0.1), exact) - plain
    chance = 0.01**2 * (full[:, 1:3] ** 2).sum()
    told = ((full[:, 1:3] @ data_of(places, 1.0)) ** 2).sum()
    for ratio, share in ((4.0, 0.0), (1.25 * 4.6, 0.25), (1.75 * 4.6, 0.75), (10.0, 1.0)):
        data = data_of(places, np.sqrt(ratio * chance / told))
        found = with_cubics(places, inside, plain, data, noise)
        np.testing.assert_allclose(found, plain + share * full, atol=1e-9)


def test_noise_alone_hardly_makes_slopes_noisier():
    places, inside = one_sided(4000)
    data = np.random.default_rng(1).normal(scale=0.01, size=(4000, 49, 2))
    plain = quadratic_operators(places, inside)
    sigma = np.where(inside, 0.01 * np.sqrt(2), 0.0)
    mixed = with_cubics(places, inside, plain, data, PointNoise(sigma, np.eye(49)))
    before, after = (((each @ data)[:, 1:3] ** 2).mean() for each in (plain, mixed))
    assert before < after < 1.2 * before  # cubics everywhere: more than six times
    assert np.mean((mixed != plain).any(axis=(1, 2))) < 0.02


def test_too_few_points_keep_their_quadratic_and_lost_ones_stay_lost():
    places, inside = one_sided(2)
    inside[0, np.flatnonzero(inside[0])[14:]] = False
    plain = quadratic_operators(places, inside)
    plain[1] = np.nan
    noise = PointNoise(np.zeros((2, 49)), np.eye(49))
    found = with_cubics(places, inside, plain, data_of(places, 0.1), noise)
    np.testing.assert_array_equal(found, plain)


def test_noise_of_windows_is_that_of_their_points_and_zero_outside():
    usable = np.ones((4, 5), dtype=bool)
    usable[0, 0] = False
    sigma = np.where(usable.ravel(), np.arange(20.0), np.nan)
    for windows in connected_windows(usable, window=3, chunk=100):
        chosen = np.ones(len(windows.centres), dtype=bool)
        noise = PointNoise(sigma, np.eye(windows.inside.shape[1])).of(windows, chosen)
        expected = np.where(windows.inside, windows.neighbours, 0)
        np.testing.assert_array_equal(noise.sigma, expected)
