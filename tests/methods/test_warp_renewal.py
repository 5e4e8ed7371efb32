"""Warps corrected by grids of points."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import gaussian_filter

from shapemorph.core.matching import Warp
from shapemorph.methods.warp_renewal import (
    continue_warp,
    fill_gaps,
    renew_warp,
    smooth_quadratic,
    spline_through,
)
from shapemorph.methods.warping import warp_points

SPACING = 5


def _identity():
    steps = np.arange(9.0)
    cols, rows = np.meshgrid(steps, steps)
    origin = np.array([-40.0, -40.0])
    return Warp(np.stack([cols, rows], axis=-1) * 40.0 + origin, origin, 40.0)


def _points(rows=26, cols=31):
    return np.stack(np.meshgrid(np.arange(cols), np.arange(rows)), axis=-1) * SPACING


def _bulge(points):
    x, y = points[..., 0] - 70.0, points[..., 1] - 55.0
    radial = 0.25 * np.exp(-(x**2 + y**2) / 2500.0)
    return points + np.stack([radial * x, radial * y], axis=-1)


def _renew(deformed, usable, reach=(6.0, 20.0), noise=0.01):
    level = np.where(usable, noise, np.nan)
    return renew_warp(_identity(), _points(), deformed, level, spacing=SPACING, reach=reach)


def test_a_quadratic_field_is_taken_over_exactly_inside():
    points = _points().astype(float)
    x, y = points[..., 0] - 60, points[..., 1] - 50
    bend = np.stack([0.001 * x * y + 0.02 * x, -0.002 * y * y + 0.001 * x * x], axis=-1)
    warp = _renew(points + bend, np.ones(points.shape[:2], dtype=bool))
    found, _ = warp_points(warp, points[6:-6, 6:-6].reshape(-1, 2))
    assert_allclose(
        found, (points + bend)[6:-6, 6:-6].reshape(-1, 2), atol=2e-5
    )  # the border fades


def test_gaps_cost_little():
    points = _points().astype(float)
    usable = np.ones(points.shape[:2], dtype=bool)
    usable[10:13, 14:17] = False
    deformed = np.where(usable[..., None], _bulge(points), np.nan)
    found, _ = warp_points(_renew(deformed, usable), points[10:13, 14:17].reshape(-1, 2))
    assert_allclose(found, _bulge(points)[10:13, 14:17].reshape(-1, 2), atol=0.3)


def test_noise_of_single_points_hardly_enters():
    points = _points().astype(float)
    noise = np.random.default_rng(0).normal(0, 0.02, points.shape)
    warp = _renew(points + noise, np.ones(points.shape[:2], dtype=bool), noise=0.02)
    found, _ = warp_points(warp, points[4:-4, 4:-4].reshape(-1, 2))
    left = found - points[4:-4, 4:-4].reshape(-1, 2)
    assert left.std() < 0.3 * 0.02


def test_a_warp_does_not_bend_with_the_noise_of_uncertain_points_at_its_rim():
    points, rng = _points().astype(float), np.random.default_rng(3)
    level = np.full(points.shape[:2], 0.01)
    level[:, :2] = 0.2
    deformed = points + level[..., None] * rng.normal(size=points.shape)
    everything = np.ones(points.shape[:2], dtype=bool)
    at = points[4:-4, 0]
    off = [
        np.abs(warp_points(_renew(deformed, everything, noise=each), at)[0] - at).mean()
        for each in (level, 0.01)
    ]
    assert off[0] < 0.5 * off[1]


def test_a_kink_is_followed_more_closely_than_by_the_wide_fit_alone():
    points = _points().astype(float)
    beyond = np.maximum(points[..., 0] - 75.0, 0.0)
    deformed = points + np.stack([0.3 * beyond, 0 * beyond], axis=-1)
    deformed += np.random.default_rng(1).normal(0, 0.005, points.shape)
    everything = np.ones(points.shape[:2], dtype=bool)
    at = points[8:-8, 15]  # on the kink
    errors = []
    for reach in ((6.0, 20.0), (20.0, 20.0)):
        found, _ = warp_points(_renew(deformed, everything, reach), at)
        errors.append(np.abs(found[:, 0] - 75.0).mean())
    assert errors[0] < 0.5 * errors[1]


def test_a_stretch_does_not_let_the_noise_along_it_bend_the_warp():
    points = _points(40, 40).astype(float)
    slope = np.diag([3.5, 3.5**-0.5])
    grid = _identity()
    warp = Warp(grid.coefficients @ slope, grid.origin, grid.spacing)
    off = gaussian_filter(np.random.default_rng(4).normal(0, 0.1, points.shape), (1, 1, 0))
    noise = np.full(points.shape[:2], off.std())
    deformed = (points + off) @ slope
    at = points[4:-4, 4:-4].reshape(-1, 2)
    renewed = renew_warp(warp, _points(40, 40), deformed, noise, spacing=SPACING, reach=(6.0, 20.0))
    left = (warp_points(renewed, at)[0] - at @ slope) @ np.linalg.inv(slope)
    assert left.std() < 0.4 * off.std()


def test_what_a_warp_of_few_features_made_up_is_left_out():
    points = _points(40, 40).astype(float)
    grid = _identity()
    made_up = np.random.default_rng(5).normal(0, 0.5, grid.coefficients.shape)
    bumpy = Warp(grid.coefficients + made_up, grid.origin, grid.spacing)
    noise = np.random.default_rng(6).normal(0, 0.01, points.shape)
    level = np.full(points.shape[:2], 0.01)
    renewed = renew_warp(
        bumpy, _points(40, 40), points + noise, level, spacing=SPACING, reach=(6.0, 20.0)
    )
    at = points[6:-6, 6:-6].reshape(-1, 2)
    assert (warp_points(bumpy, at)[0] - at).std() > 0.1
    assert (warp_points(renewed, at)[0] - at).std() < 0.01


def test_details_that_a_warp_knows_are_kept():
    points = _points(40, 40).astype(float)
    steps = 10.0 * np.arange(-3, 24)
    wave = np.stack(np.meshgrid(steps, steps), axis=-1)
    wave[..., 0] += 0.3 * np.sin(2 * np.pi * wave[..., 1] / 60.0)
    warp = Warp(spline_through(wave), np.full(2, -30.0), 10.0)
    true = points.copy()
    true[..., 0] += 0.3 * np.sin(2 * np.pi * points[..., 1] / 60.0)
    noise = np.random.default_rng(7).normal(0, 0.01, points.shape)
    level = np.full(points.shape[:2], 0.01)
    renewed = renew_warp(
        warp, _points(40, 40), true + noise, level, spacing=SPACING, reach=(6.0, 20.0)
    )
    inner = (slice(6, -6), slice(6, -6))
    off = warp_points(renewed, points[inner].reshape(-1, 2))[0] - true[inner].reshape(-1, 2)
    assert off.std() < 0.01


def test_a_warp_is_continued_linearly():
    warp = _identity()
    outside = np.array([[-500.0, 20.0], [900.0, -300.0]])
    assert_allclose(continue_warp(warp, outside), outside, atol=1e-9)


@pytest.mark.parametrize("spacing", [21.711420812498535, 7.3, 1 / 3])
def test_rounding_at_the_border_of_a_warp_loses_nothing(spacing):
    origin = np.array([-48.23844341, -45.10418097])
    cols, rows = np.meshgrid(np.arange(34.0), np.arange(28.0))
    warp = Warp(origin + spacing * np.stack([cols, rows], axis=-1), origin, spacing)
    far = np.array([[-1e3, 9.0], [1e3, 9.0], [9.0, 1e3], [1e3, 1e3], [9.0, -1e3]])
    assert_allclose(continue_warp(warp, far), far, atol=1e-6)


def test_gaps_are_filled_with_what_is_near():
    values, known = np.zeros((12, 15, 2)), np.zeros((12, 15), dtype=bool)
    values[:, :3], known[:, :3] = [1.0, 2.0], True
    values[~known] = np.nan
    assert_allclose(fill_gaps(values, known), np.broadcast_to([1.0, 2.0], (12, 15, 2)), atol=1e-9)


@pytest.mark.parametrize("reach", [1.2, 4.0])
def test_a_local_quadratic_fit_reproduces_a_quadratic_to_the_rim(reach):
    rows, cols = np.mgrid[:20, :26].astype(float)
    values = (1 + 0.3 * rows - 0.2 * cols + 0.02 * rows * cols - 0.01 * cols**2)[..., None]
    known = np.ones((20, 26), dtype=bool)
    known[5:8, 9] = False
    smooth, sound = smooth_quadratic(values, known.astype(float), reach=reach)
    assert sound.all()
    assert_allclose(smooth, values, atol=2e-3)  # a ridge of 1e-6 of the weight
