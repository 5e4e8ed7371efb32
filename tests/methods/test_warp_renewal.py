"""Warps corrected by grids of points."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import gaussian_filter

from shapemorph.core.matching import Warp
from shapemorph.methods.warp_renewal import (
    FoundGrid,
    continue_warp,
    renew_warp,
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
    return renew_warp(_identity(), FoundGrid(_points(), deformed, level, SPACING), reach=reach)


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
    renewed = renew_warp(
        warp, FoundGrid(_points(40, 40), deformed, noise, SPACING), reach=(6.0, 20.0)
    )
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
        bumpy, FoundGrid(_points(40, 40), points + noise, level, SPACING), reach=(6.0, 20.0)
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
        warp, FoundGrid(_points(40, 40), true + noise, level, SPACING), reach=(6.0, 20.0)
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


def _disc(radius, width=131):
    rows, cols = np.mgrid[:width, :width]
    return np.hypot(rows - 65, cols - 65) < radius


def _seen_through(truth, warp, mask, half):
    """Where affine subsets find the points of a grid, and what they make of bending."""
    points = np.stack(np.meshgrid(np.arange(27), np.arange(27)), axis=-1) * SPACING
    steps = np.arange(-half, half + 1)
    around = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    padded = np.pad(mask, half)
    deformed, seen = np.full(points.shape, np.nan), np.zeros((27, 27, 3))
    share = np.zeros((27, 27))
    x, y = around.T / half
    bent = np.column_stack([x * x, x * y, y * y]) * half**2
    affine = np.column_stack([np.ones(len(x)), x, y])
    for at in np.argwhere(mask[::SPACING, ::SPACING]):
        point = points[tuple(at)]
        inside = padded[(point[1] + half + around[:, 1]), (point[0] + half + around[:, 0])]
        share[tuple(at)] = inside.mean()
        places = (point + around)[inside].astype(float)
        left = truth(places) - continue_warp(warp, places)
        fit = np.linalg.pinv(affine[inside])[0]
        deformed[tuple(at)] = continue_warp(warp, point[None].astype(float))[0] + fit @ left
        seen[tuple(at)] = fit @ bent[inside]
    return points, deformed, seen, share


def _off_at_rim(reckoned):
    """Errors of a warp beside the rim of a disc where the warp before it was wrong."""

    def truth(places):
        x, y = (places - 65.0).T / 65.0
        return places + np.column_stack([6 * x * x + 3 * x**3, 4 * x * y - 3 * y**3])

    knots = np.stack(np.meshgrid(np.arange(-10, 24), np.arange(-10, 24)), axis=-1) * 7.0
    away = knots - 65.0
    far = np.maximum(np.linalg.norm(away, axis=-1) - 45.0, 0.0)
    flat = truth(knots.reshape(-1, 2)).reshape(knots.shape) + 1e-3 * far[..., None] ** 2
    before = Warp(spline_through(flat), np.array([-70.0, -70.0]), 7.0)
    mask = _disc(60.0)
    points, deformed, seen, share = _seen_through(truth, before, mask, 9)
    noise = np.where(share > 0, 0.01, np.nan)
    whole = share == 1.0
    grid = FoundGrid(points, deformed, noise, SPACING, seen if reckoned else None, whole)
    places = points[share > 0].astype(float)
    places = places[np.hypot(*(places - 65.0).T) > 55.0]
    found, _ = warp_points(renew_warp(before, grid, reach=(5.7, 19.0)), places)
    start, _ = warp_points(before, places)
    return (np.abs(each - truth(places)).mean() for each in (found, start))


def test_what_cut_subsets_saw_of_a_wrong_warp_is_reckoned_with():
    off, start = _off_at_rim(reckoned=True)
    assert start > 0.1
    assert off < 0.05 * start
    assert off < 0.3 * next(_off_at_rim(reckoned=False))


def test_pieces_that_lie_apart_do_not_feel_each_other():
    points = np.stack(np.meshgrid(np.arange(50), np.arange(20)), axis=-1) * SPACING
    apart = (points[..., :1] >= 150) * np.array([300.0, -80.0])
    level = np.where((points[..., 0] < 80) | (points[..., 0] >= 150), 0.01, np.nan)
    grid = FoundGrid(points, points + apart + 0.25, level, SPACING)
    here = points[np.isfinite(level)].astype(float)
    knots = np.stack(np.meshgrid(np.arange(-10, 65), np.arange(-10, 35)), axis=-1) * 5.0
    jump = (knots[..., :1] >= 115) * np.array([300.0, -80.0])
    before = Warp(spline_through(knots + jump), np.array([-50.0, -50.0]), 5.0)
    found, _ = warp_points(renew_warp(before, grid, reach=(6.0, 20.0)), here)
    moved = (points + apart)[np.isfinite(level)] + 0.25
    assert_allclose(found, moved, atol=2e-3)


def test_a_few_points_alone_are_no_piece():
    points = np.stack(np.meshgrid(np.arange(40), np.arange(20)), axis=-1) * SPACING
    level = np.where(points[..., 0] < 80, 0.01, np.nan)
    level[10, 35] = 0.01
    warp = renew_warp(_identity(), FoundGrid(points, points + 0.25, level, SPACING), reach=(6, 20))
    at = np.array([[175.0, 50.0], [180.0, 53.0], [40.0, 40.0]])
    assert_allclose(warp_points(warp, at)[0], at + 0.25, atol=1e-3)
