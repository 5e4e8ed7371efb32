from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter, laplace, uniform_filter

from shapemorph.config import StrainConfig
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.surface import TrackedSurface
from shapemorph.methods.field_noise import (
    interpolated_noise,
    match_correlation,
    overlap_correlation,
    position_covariance,
    scatter_about_fits,
)
from shapemorph.methods.quadratic_fit import cubic_changes
from shapemorph.stages.strain import strain

SPACING, SUBSET = 7, 19  # px


def averaged_noise(rng, rows, cols, sigma):
    """Errors at grid points that share the noise of overlapping subsets, (R, C, 2)."""
    height, width = rows * SPACING + SUBSET, cols * SPACING + SUBSET
    noise = uniform_filter(rng.normal(size=(height, width, 2)), (SUBSET, SUBSET, 1))
    start = SUBSET // 2
    down = slice(start, start + rows * SPACING, SPACING)
    right = slice(start, start + cols * SPACING, SPACING)
    return noise[down, right] * SUBSET * sigma


def test_overlap_correlation_is_that_of_averages_over_subsets():
    rng = np.random.default_rng(9)
    offsets = np.array([[0, 0], [1, 0], [1, 1], [2, 1], [3, 0]])
    expected = overlap_correlation(offsets, spacing=SPACING, subset_size=SUBSET)
    field = averaged_noise(rng, 120, 130, 1.0)[..., 0]
    shifted = [field[dy : 110 + dy, dx : 110 + dx].ravel() for dx, dy in offsets]
    np.testing.assert_allclose(np.corrcoef(shifted), expected, atol=0.04)  # 12 100 draws


def test_noise_along_the_surface_adds_pictures_and_both_meshes():
    reference = np.array([[[0.1, 0.0], [0.0, 0.1], [0.0, 0.0]]])
    deformed = np.array([[[0.2, 0.0], [0.0, 0.0], [0.0, 0.1]]])
    gradient = np.array([[[1.5, 0.0], [0.0, 1.0]]])
    found = position_covariance(
        (reference, deformed),
        gradient,
        np.array([[[0.03**2, 0.0004], [0.0004, 0.05**2]]]),
        np.array([[0.002, 0.003]]),
    )
    along = (0.2 * 0.03) ** 2 + (3 * 0.002) ** 2 + 0.003**2  # the surface is stretched by 3
    other = (0.1 * 0.05) ** 2 + 0.002**2 + 0.003**2
    expected = np.diag([along, 0, other])
    expected[0, 2] = expected[2, 0] = 0.2 * 0.0004 * 0.1
    np.testing.assert_allclose(found[0], expected, atol=1e-18)


def test_errors_of_matches_in_a_renewed_warp_are_correlated_as_filtered_noise():
    rng = np.random.default_rng(13)
    noise = rng.normal(size=(900, 900))
    average = uniform_filter(noise, SUBSET, mode="wrap")

    def smoothed(field):  # quadratic fit with Gaussian weights, value at its centre
        reach = 0.3 * SUBSET
        once = gaussian_filter(field, reach, mode="wrap", truncate=6)
        return once - reach**2 / 2 * laplace(once, mode="wrap")

    errors = average + smoothed(average) - uniform_filter(smoothed(average), SUBSET, mode="wrap")
    offsets = np.array([[0, 0], [1, 0], [2, 0], [3, 1], [2, 2]])
    found = match_correlation(offsets, spacing=SPACING, subset_size=SUBSET, smoothing=0.3)
    shifted = [
        np.roll(errors, (-dy * SPACING, -dx * SPACING), (0, 1)).ravel() for dx, dy in offsets
    ]
    np.testing.assert_allclose(np.corrcoef(shifted), found, atol=0.04)
    plain = match_correlation(offsets, spacing=SPACING, subset_size=SUBSET, smoothing=0.0)
    expected = overlap_correlation(offsets, spacing=SPACING, subset_size=SUBSET)
    np.testing.assert_array_equal(plain, expected)


def test_scatter_is_that_of_the_noise_through_kinks_and_wrong_matches():
    rng = np.random.default_rng(12)
    tracked, grid = tracked_sheet(rng, "pictures")
    covariance = np.diag([*(0.08 * np.diag(ERRORS["pictures"][2])) ** 2 / 4, 0.0])  # half of it
    deformed = tracked.deformed.copy()
    deformed[20, 30] += 5.0
    deformed[:, 45:, 1] += 0.1 * np.arange(15)
    shape = deformed.shape[:2]
    known = np.broadcast_to(covariance, (*shape, 3, 3))
    changed = replace(tracked, deformed=deformed, covariance=known)
    field = strain(changed, grid, StrainConfig())
    assert field.scatter == pytest.approx(2.0, rel=0.1)
    bare = strain(tracked, grid, StrainConfig())
    assert bare.scatter == 1.0
    quiet, kink = (slice(0, 40), slice(0, 25)), (slice(0, 40), 44)
    ratio = field.sigma_e1 / bare.sigma_e1
    assert np.median(ratio[*quiet]) == pytest.approx(2.0, rel=0.1)
    assert (ratio[*kink] > 2 * field.scatter).all()  # the fits do not follow it


def test_scatter_is_told_along_and_across_the_stretch():
    rng = np.random.default_rng(14)
    tracked, grid = tracked_sheet(rng, "stretched pictures")
    direction = np.linalg.eigh(CHANGE.T @ CHANGE)[1][:, 1]
    along = CHANGE @ direction / np.linalg.norm(CHANGE @ direction)
    shrink = np.eye(2) - 0.5 * np.outer(along, along)  # half as much as there is, along it
    true = (0.08 * 0.02) ** 2 * CHANGE @ CHANGE.T
    covariance = np.zeros((*tracked.status.shape, 3, 3))
    covariance[..., :2, :2] = shrink @ true @ shrink
    field = strain(replace(tracked, covariance=covariance), grid, StrainConfig())
    bare = strain(tracked, grid, StrainConfig())
    inner = (slice(3, -3), slice(3, -3))
    assert np.median((field.sigma_e1 / bare.sigma_e1)[inner]) == pytest.approx(2.0, rel=0.1)
    assert np.median((field.sigma_e2 / bare.sigma_e2)[inner]) == pytest.approx(1.0, rel=0.1)
    assert 1.5 < field.scatter < 2.0


def test_scatter_is_told_around_each_point():
    rng = np.random.default_rng(15)
    tracked, grid = tracked_sheet(rng, "pictures")
    exact = np.zeros_like(tracked.deformed)
    exact[..., :2] = tracked.reference[..., :2] @ CHANGE.T
    louder = np.where(np.arange(tracked.status.shape[1]) >= 30, 2.0, 1.0)[None, :, None]
    covariance = np.diag([*(0.08 * np.diag(ERRORS["pictures"][2])) ** 2, 0.0])
    changed = replace(
        tracked,
        deformed=exact + louder * (tracked.deformed - exact),
        covariance=np.broadcast_to(covariance, (*tracked.status.shape, 3, 3)),
    )
    field, bare = strain(changed, grid, StrainConfig()), strain(tracked, grid, StrainConfig())
    ratio = (field.sigma_e1 / bare.sigma_e1)[3:-3]
    assert np.median(ratio[:, 3:18]) == pytest.approx(1.0, rel=0.15)
    assert np.median(ratio[:, 42:-3]) == pytest.approx(2.0, rel=0.15)


def test_cubic_terms_change_the_slopes_of_cubics_alone():
    offsets = np.stack(np.meshgrid(np.arange(-2, 3), np.arange(-2, 3)), axis=-1).reshape(-1, 2)
    x, y = offsets.T.astype(float)
    data = np.stack([1 + 2 * x - y + x * y + 3 * y**2, x**3, y**3], axis=1)
    # the best line through x^3 at -2 ... 2 has the slope 34 / 10
    expected = [[0, -3.4, 0], [0, 0, -3.4]]
    np.testing.assert_allclose(cubic_changes(offsets) @ data, expected, atol=1e-12)


def test_few_windows_do_not_tell_the_scatter():
    offsets = np.stack(np.meshgrid(range(3), range(3)), axis=-1).reshape(-1, 2)
    nothing = np.ones((9, 11, 2))
    overall, of_slopes = scatter_about_fits(nothing, nothing, nothing, np.eye(9), offsets)
    assert overall == 1.0
    assert (of_slopes == 1.0).all()


def test_interpolation_between_three_vertices_averages_their_noise():
    weights = np.array([[1.0, 0, 0], [0.5, 0.5, 0]])
    found = interpolated_noise(weights, vertex_noise=0.006)
    np.testing.assert_allclose(found, [0.006, 0.006 / np.sqrt(2)])


CHANGE = np.array([[2.0, 0.9], [0.1, 1.2]])


def tracked_sheet(rng, source):
    """Sheet of 0.1 mm/px under CHANGE, matched with errors that come from one source."""
    rows, cols = 50, 60
    j, i = np.meshgrid(np.arange(cols), np.arange(rows))
    picture = np.stack([j, i], axis=-1) * float(SPACING)
    error = averaged_noise(rng, rows, cols, 1.0)
    before, after = (error * part for part in ERRORS[source][:2])
    mixed = ERRORS[source][2]
    after_px = error @ mixed.T
    covariance = mixed @ mixed.T
    deformed = (0.1 * picture + before) @ CHANGE.T + after
    deformed_px = deformed / 0.08 + after_px  # the deformed picture has 0.08 mm/px
    flat = np.zeros((rows, cols, 1))
    normal = np.broadcast_to([0.0, 0, 1], (rows, cols, 3))
    tracked = TrackedSurface(
        np.concatenate([0.1 * picture, flat], axis=-1),
        np.concatenate([0.08 * deformed_px, flat], axis=-1),
        normal,
        normal,
        np.full((rows, cols), 0.003),
        np.zeros((rows, cols), dtype=np.uint8),
        np.zeros(2),
        np.broadcast_to([np.max(ERRORS[source][0]), np.max(ERRORS[source][1])], (rows, cols, 2)),
    )
    grid = CorrelationGrid(
        picture,
        deformed_px,
        np.broadcast_to(CHANGE, (rows, cols, 2, 2)),
        np.ones((rows, cols)),
        np.ones((rows, cols), dtype=np.int64),
        np.broadcast_to(np.sqrt(np.diag(covariance)), (rows, cols, 2)),
        tracked.status,
        SPACING,
        SUBSET,
        0.0,
        shared_px2=np.full((rows, cols), covariance[0, 1]),
    )
    return tracked, grid


NONE = np.zeros(2)
ERRORS = {  # on the reference surface (mm), on the deformed surface (mm), in the picture (px)
    "pictures": (NONE, NONE, np.diag([0.04, 0.02])),
    "stretched pictures": (NONE, NONE, 0.02 * CHANGE),
    "reference mesh": (np.full(2, 0.003), NONE, np.zeros((2, 2))),
    "deformed mesh": (NONE, np.full(2, 0.003), np.zeros((2, 2))),
}


@pytest.mark.parametrize("source", ERRORS)
def test_predicted_noise_of_strain_is_that_of_repeated_measurements(source):
    rng = np.random.default_rng(10)
    fields = [strain(*tracked_sheet(rng, source), StrainConfig()) for _ in range(3)]
    true = (CHANGE.T @ CHANGE - np.eye(2)) / 2
    off = np.stack([field.tensor for field in fields])[:, 3:-3, 3:-3] - true
    components = np.stack([off[..., 0, 0], off[..., 1, 1], off[..., 0, 1]], axis=-1)
    measured = np.sqrt(np.mean(components**2, axis=(0, 1, 2)))
    predicted = np.median(fields[0].sigma_tensor[3:-3, 3:-3], axis=(0, 1))
    # three draws of 44 x 54 points in windows that overlap: some 500 independent ones
    np.testing.assert_allclose(predicted, measured, rtol=0.1)
    values = np.linalg.eigvalsh(true)
    for found, sigma, value in (("e1", "sigma_e1", values[1]), ("e2", "sigma_e2", values[0])):
        error = np.stack([getattr(field, found) for field in fields])[:, 3:-3, 3:-3] - value
        expected = np.median(getattr(fields[0], sigma)[3:-3, 3:-3])
        np.testing.assert_allclose(expected, np.sqrt(np.mean(error**2)), rtol=0.1)


def test_two_thirds_of_the_errors_lie_within_sigma_up_to_the_rim():
    rng = np.random.default_rng(11)
    field = strain(*tracked_sheet(rng, "pictures"), StrainConfig())
    error = field.e1 - np.linalg.eigvalsh((CHANGE.T @ CHANGE - np.eye(2)) / 2)[1]
    within = np.abs(error) <= field.sigma_e1
    assert within.mean() == pytest.approx(0.683, abs=0.06)
    assert within[:, :2].mean() == pytest.approx(0.683, abs=0.15)
