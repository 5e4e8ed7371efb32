"""Correlation of pictures that are known exactly, through warps that are only nearly right."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.ndimage import gaussian_filter

from shapemorph.config import CorrelateConfig
from shapemorph.core.errors import StageError
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.core.morphed import Morphed
from shapemorph.core.status import PointStatus
from shapemorph.methods.laws.identity import identity_warp
from shapemorph.methods.near_start import start_from
from shapemorph.methods.subset_dic import SubsetSettings
from shapemorph.methods.synthetic.planar import planar_speckle
from shapemorph.methods.warping import warp_points
from shapemorph.stages.correlate import correlate

SHAPE = (150, 190)
CENTRE = np.array([95.0, 75.0])


def _bulge(points):
    """A stretch of 1.6 in the middle that fades outwards, turned by 30 degrees."""
    local = points - CENTRE
    distance = (local**2).sum(axis=-1, keepdims=True)
    stretched = local * (1.0 + 0.6 * np.exp(-distance / 2 / 45.0**2))
    angle = np.radians(30.0)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return stretched @ turn.T + [160.0, 140.0]


def _inverse(points):
    guess = np.broadcast_to(CENTRE, points.shape).copy()
    for _ in range(40):
        off = (points - _bulge(guess))[..., None]
        guess = guess + np.linalg.solve(_slope(guess, 1e-4), off)[..., 0]
    return guess


def _slope(points, step):
    right, down = np.array([step, 0.0]), np.array([0.0, step])
    along_x = (_bulge(points + right) - _bulge(points - right)) / (2 * step)
    along_y = (_bulge(points + down) - _bulge(points - down)) / (2 * step)
    return np.stack([along_x, along_y], axis=-1)


def _warp_near(error, seed=0):
    """A warp that is off by a smooth field of `error` px."""
    rng, spacing = np.random.default_rng(seed), 25.0
    origin = np.array([-75.0, -75.0])
    cols, rows = np.meshgrid(np.arange(14.0), np.arange(12.0))
    knots = origin + spacing * np.stack([cols, rows], axis=-1)
    return Warp(_bulge(knots) + rng.normal(0, error, knots.shape), origin, spacing)


class Scene:
    """The pattern, seen through any warp without interpolation."""

    def __init__(self, pattern, pixels, noise=0.0, hole=None, seed=7):
        rng = np.random.default_rng(seed)
        self.pattern, self.pixels, self.hole = pattern, pixels, hole
        self.noise = rng.normal(0, noise, (2, *SHAPE))
        mask = self._covered(pixels)
        self.reference = GreyImage((pattern(pixels) + self.noise[0]).astype("f4"), mask)

    def _covered(self, material):
        if self.hole is None:
            return np.isfinite(material).all(axis=-1)
        return np.hypot(*np.moveaxis(material - self.hole, -1, 0)) > 20.0

    def remorph(self, warp):
        targets, _ = warp_points(warp, self.pixels.reshape(-1, 2))
        material = _inverse(targets).reshape(self.pixels.shape)
        grey = 0.8 * self.pattern(material) + 0.1 + self.noise[1]
        return GreyImage(np.nan_to_num(grey).astype("f4"), self._covered(material))

    def correlate(self, warp, region=None, **config):
        morphed = Morphed(self.remorph(warp), warp)
        section = CorrelateConfig(**({"subset_size": 21, "spacing": 6} | config))
        return correlate(self.reference, self.remorph, morphed, section, region)


@pytest.fixture
def scene(wave_pattern, pixel_grid):
    def make(**options):
        return Scene(wave_pattern(), pixel_grid(SHAPE), **options)

    return make


def _error(grid):
    ok = grid.status == PointStatus.OK
    return (grid.deformed_px - _bulge(grid.reference_px))[ok]


def test_a_large_deformation_is_found_through_a_warp_that_is_nearly_right(scene):
    grid = scene().correlate(_warp_near(0.5))
    tried = grid.status != PointStatus.OUTSIDE_MASK
    assert (grid.status == PointStatus.OK).sum() > 0.97 * tried.sum()
    error = _error(grid)
    assert np.sqrt((error**2).mean()) < 0.015  # curvature that is left after one renewal
    assert np.abs(error).max() < 0.1


def _moved_speckle(shift, blur):
    """Noisy speckle of 5 px, and the same moved and out of focus by `blur` px."""
    rng = np.random.default_rng(0)
    cols, rows = np.meshgrid(np.arange(320.0), np.arange(320.0))
    speckle = planar_speckle(diameter=5.0, seed=1)
    sharp, moved = (
        0.5 + 0.15 * speckle.at(np.stack([cols, rows], axis=-1) - by) for by in (0.0, shift)
    )
    noise = rng.normal(0.0, 2 / 255, (2, 320, 320))
    mask = np.ones(sharp.shape, dtype=bool)
    soft = GreyImage((gaussian_filter(moved, blur) + noise[1]).astype("f4"), mask)
    return GreyImage((sharp + noise[0]).astype("f4"), mask), soft


def _correlate_as_they_are(reference, deformed):
    start = Morphed(deformed, identity_warp(reference.shape))
    return correlate(reference, lambda _warp: deformed, start, CorrelateConfig(refinements=0), None)


def test_a_side_out_of_focus_is_matched_as_well_as_it_shows():
    shift = np.array([0.3, -0.2])
    grid = _correlate_as_they_are(*_moved_speckle(shift, 2.0))
    ok = grid.status == PointStatus.OK
    inner = (np.abs(grid.reference_px - 160.0) < 130.0).all(axis=-1)
    assert ok[inner].all()
    error = grid.deformed_px[inner] - grid.reference_px[inner] - shift
    assert np.sqrt((error**2).mean()) < 0.035
    assert np.median(grid.zncc[inner]) > 0.98


def test_subset_and_spacing_do_not_depend_on_the_morph():
    sharp, soft = (_correlate_as_they_are(*_moved_speckle(0.3, blur)) for blur in (0.0, 2.0))
    assert soft.subset_size == sharp.subset_size
    assert_array_equal(soft.reference_px, sharp.reference_px)


def test_the_gradient_is_that_of_the_whole_map(scene):
    # the warp is sheared, so that the motion left to find does not commute with it
    exact, shear = _warp_near(0.0), np.array([[1.0, 0.06], [-0.02, 0.97]])
    rows, cols = exact.coefficients.shape[:2]
    knots = np.stack(np.meshgrid(np.arange(cols), np.arange(rows)), axis=-1) * exact.spacing
    knots = (knots + exact.origin - CENTRE) @ shear.T + CENTRE
    sheared = Warp(_bulge(knots), exact.origin, exact.spacing)
    region = np.zeros(SHAPE, dtype=bool)
    region[55:95, 75:115] = True
    grid = scene().correlate(sheared, region, refinements=0)
    inner = (grid.status == PointStatus.OK) & (np.abs(grid.reference_px - CENTRE) < 12).all(axis=-1)
    assert inner.sum() > 8
    expected = _slope(grid.reference_px[inner], 1e-3)
    assert_allclose(grid.gradient[inner], expected, atol=0.01)


def test_a_renewed_morph_takes_away_what_the_shape_function_cannot_follow(scene):
    once, again = (scene().correlate(_warp_near(1.5), refinements=n) for n in (0, 1))
    before, after = (np.sqrt((_error(grid) ** 2).mean()) for grid in (once, again))
    assert after < 0.4 * before


def test_sigma_is_carried_into_the_deformed_picture(scene):
    grids = [scene(noise=2 / 255, seed=n).correlate(_warp_near(0.2)) for n in (7, 8)]
    ok = np.all([grid.status == PointStatus.OK for grid in grids], axis=0)
    error = (grids[0].deformed_px - grids[1].deformed_px)[ok] / np.sqrt(2.0)
    ratio = np.sqrt((error**2).mean()) / np.sqrt((grids[0].sigma_px[ok] ** 2).mean())
    assert ratio == pytest.approx(1.05, abs=0.15)  # a renewed warp adds a little


def test_x_and_y_errors_share_what_a_stretch_between_them_gives_both(wave_pattern, pixel_grid):
    pattern, pixels = wave_pattern(), pixel_grid(SHAPE)
    noise = np.random.default_rng(9).normal(0, 0.01, (2, *SHAPE))
    full = np.ones(SHAPE, dtype=bool)
    before, after = (GreyImage((pattern(pixels) + each).astype("f4"), full) for each in noise)
    stretch = np.array([[1.5, 0.5], [0.5, 1.5]])  # 2 along a diagonal, 1 across it
    cols, rows = np.meshgrid(np.arange(14.0), np.arange(12.0))
    knots = 25.0 * np.stack([cols, rows], axis=-1) - 75.0
    section = CorrelateConfig(subset_size=21, spacing=6, refinements=0)
    plain, drawn = (
        correlate(
            before,
            lambda _: after,
            Morphed(after, Warp(knots @ matrix.T, np.array([-75.0, -75.0]), 25.0)),
            section,
            None,
        )
        for matrix in (np.eye(2), stretch)
    )
    assert_allclose(drawn.covariance_px2, stretch @ plain.covariance_px2 @ stretch.T, rtol=1e-6)
    middle = np.median(drawn.covariance_px2[3:-3, 3:-3], axis=(0, 1))
    assert middle[0, 1] > 0.4 * np.sqrt(middle[0, 0] * middle[1, 1])


def test_the_field_reaches_the_rim_of_a_hole(scene):
    hole = np.array([70.0, 80.0])
    grid = scene(hole=hole).correlate(_warp_near(0.3), spacing=4)
    distance = np.hypot(*np.moveaxis(grid.reference_px - hole, -1, 0))
    assert (grid.status[distance <= 20] == PointStatus.OUTSIDE_MASK).all()
    near = (distance > 22.0) & (distance < 27.0)
    assert (grid.status[near] == PointStatus.OK).mean() > 0.95
    rim = near & (grid.status == PointStatus.OK)
    assert np.abs((grid.deformed_px - _bulge(grid.reference_px))[rim]).max() < 0.15


def test_the_region_limits_the_points(scene):
    region = np.zeros(SHAPE, dtype=bool)
    region[30:90, 40:120] = True
    grid = scene().correlate(_warp_near(0.3), region)
    assert grid.reference_px[..., 0].min() >= 40
    assert grid.reference_px[..., 1].max() < 90
    assert (grid.reference_px % 6 == 0).all()
    assert grid.ok_count > 0


def test_foreign_material_is_lost_and_the_rest_is_not(scene, wave_pattern):
    view = scene()
    own, foreign = view.pattern, wave_pattern(seed=55)

    def patched(material):
        spot = np.hypot(*np.moveaxis(material - [110.0, 60.0], -1, 0)) < 18.0
        return np.where(spot, foreign(material), own(material))

    view.pattern = patched
    view.reference = GreyImage(own(view.pixels).astype("f4"), view.reference.mask)
    grid = view.correlate(_warp_near(0.3))
    distance = np.hypot(*np.moveaxis(grid.reference_px - [110.0, 60.0], -1, 0))
    assert not (grid.status[distance < 10] == PointStatus.OK).any()
    assert (grid.status[distance > 32] == PointStatus.OK).mean() > 0.97
    ok = grid.status == PointStatus.OK
    wrong = np.abs((grid.deformed_px - _bulge(grid.reference_px))[ok]).max(axis=-1) > 0.5
    assert wrong.sum() == 0


def test_threads_change_no_bit(scene):
    one, two = (scene(noise=0.01).correlate(_warp_near(0.3), threads=n) for n in (1, 2))
    for name in ("deformed_px", "gradient", "zncc", "iterations", "sigma_px", "status"):
        assert_array_equal(getattr(one, name), getattr(two, name))


def test_pictures_of_two_things_are_an_error_with_counts(scene, wave_pattern):
    view = scene()
    view.pattern = wave_pattern(seed=77)
    with pytest.raises(StageError, match=r"got none of \d+ \(.*LOW_ZNCC"):
        view.correlate(_warp_near(0.3))


def test_iterations_that_do_not_settle_are_an_error_that_says_so(scene):
    with pytest.raises(StageError, match=r"NOT_CONVERGED\): .* raise correlate\.max_iterations"):
        scene(noise=0.01).correlate(_warp_near(0.3), max_iterations=1, tolerance=1e-9)


def test_a_region_between_the_points_is_an_error(scene):
    region = np.zeros(SHAPE, dtype=bool)
    region[31:33, 61:65] = True
    with pytest.raises(StageError, match="every 6 px"):
        scene().correlate(_warp_near(0.3), region)


def test_paper_mode_gives_the_same_grid_less_exactly(scene):
    grid = scene().correlate(_warp_near(0.5), mode="paper")
    tried = grid.status != PointStatus.OUTSIDE_MASK
    assert grid.ok_count > 0.9 * tried.sum()
    assert 0.005 < np.sqrt((_error(grid) ** 2).mean()) < 0.1
    assert np.isfinite(grid.sigma_px[grid.status == PointStatus.OK]).all()


def test_a_quintic_spline_is_biased_less_on_a_fine_pattern(wave_pattern, pixel_grid):
    pattern, pixels, whole = wave_pattern(size=2.2), pixel_grid(SHAPE), np.ones(SHAPE, dtype=bool)
    shift = np.array([0.25, 0.0])
    first, second = (GreyImage(pattern(at).astype("f4"), whole) for at in (pixels, pixels - shift))
    still = Morphed(second, identity_warp(SHAPE))
    biases = []
    for interpolation in ("cubic", "quintic"):
        config = CorrelateConfig(
            subset_size=21, spacing=12, refinements=0, interpolation=interpolation
        )
        grid = correlate(first, lambda _: second, still, config, None)
        found = grid.status == PointStatus.OK
        assert found.sum() > 150
        biases.append(np.abs((grid.deformed_px - grid.reference_px)[found].mean(axis=0) - shift))
    assert biases[0].max() > 1e-3
    assert biases[1].max() < 0.3 * biases[0].max()


def test_the_bias_is_that_of_the_morph_that_was_matched(scene):
    grid = scene().correlate(_warp_near(1.5), refinements=0)
    known = np.isfinite(grid.bias_px).all(axis=-1)
    assert known.sum() > 0.9 * grid.ok_count
    error = (grid.deformed_px - _bulge(grid.reference_px))[known]
    corrected = error - grid.bias_px[known]
    assert np.sqrt((corrected**2).mean()) < 0.6 * np.sqrt((error**2).mean())


@pytest.mark.parametrize(("bend", "morphs"), [(0.0, 0), (2e-4, 1)])
def test_a_picture_is_morphed_only_where_the_field_bends(bend, morphs, wave_pattern, pixel_grid):
    pattern, pixels = wave_pattern(), pixel_grid(SHAPE)

    def forward(points):
        x = points[..., :1]
        return points + np.array([0.6, -1.3]) + bend * (x - 95.0) ** 2 * np.array([1.0, 0.0])

    def back(points):
        guess = points.copy()
        for _ in range(60):
            guess = guess + 0.8 * (points - forward(guess))
        return guess

    whole = np.ones(SHAPE, dtype=bool)
    reference = GreyImage(pattern(pixels).astype("f4"), whole)
    deformed = GreyImage(pattern(back(pixels)).astype("f4"), whole)
    made = []

    def remorph(warp):
        made.append(warp)
        targets, _ = warp_points(warp, pixels.reshape(-1, 2))
        return GreyImage(pattern(back(targets)).reshape(SHAPE).astype("f4"), whole)

    still = identity_warp(SHAPE)
    warp = Warp(still.coefficients + np.array([0.3, -1.0]), still.origin, still.spacing)
    start = start_from(warp, reference, deformed, settings=SubsetSettings(10, 1, 0.01, 30, 0.5, 10))
    settings = CorrelateConfig(subset_size=21, spacing=8)
    grid = correlate(reference, remorph, Morphed(deformed, still), settings, None, start)
    assert len(made) == morphs
    ok = grid.status == PointStatus.OK
    assert ok.mean() > 0.9
    error = (grid.deformed_px - forward(grid.reference_px))[ok]
    assert np.percentile(np.abs(error), 95) < 0.01
