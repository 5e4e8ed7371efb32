import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.core.errors import DataError
from shapemorph.methods.warp_fit import fit_warp, fit_warp_checked, fold_share
from shapemorph.methods.warping import warp_points

EXTENT = (np.array([-20.0, -10.0]), np.array([620.0, 410.0]))


def curved(points):
    """A smooth map with curvature in both components, x and y unlike."""
    x, y = points[..., 0], points[..., 1]
    u = 30 + 1.3 * x - 0.2 * y + 12 * np.sin(x / 90) * np.cos(y / 70)
    v = -8 + 0.25 * x + 0.8 * y + 9 * np.exp(-((x - 300) ** 2 + (y - 180) ** 2) / 140**2)
    return np.stack([u, v], axis=-1)


def kinked(points):
    """Stretch 1 left of x = 300, stretch 1.6 right of it."""
    x, y = points[..., 0], points[..., 1]
    return np.stack([x + 0.6 * np.maximum(x - 300, 0), y], axis=-1)


def scattered(count, seed=0):
    return np.random.default_rng(seed).uniform([0, 0], [600, 400], (count, 2))


def misfit(warp, truth, points):
    return np.linalg.norm(warp_points(warp, points)[0] - truth(points), axis=1)


def probe(step=9.0):
    grid = np.meshgrid(np.arange(5, 596, step), np.arange(5, 396, step))
    return np.stack(grid, axis=-1).reshape(-1, 2)


@pytest.mark.parametrize("smoothing", [1e-3, None])
def test_linear_map_is_reproduced_exactly_over_the_whole_extent(smoothing):
    points = scattered(200)
    linear = np.array([[1.2, -0.3], [0.4, 0.7]])
    warp = fit_warp(
        points, points @ linear.T + 5.0, extent=EXTENT, spacing=50.0, smoothing=smoothing
    )
    corners = np.array([EXTENT[0], EXTENT[1], [EXTENT[0][0], EXTENT[1][1]]])
    targets, gradient = warp_points(warp, corners)
    assert_allclose(targets, corners @ linear.T + 5.0, atol=1e-6)
    assert_allclose(gradient, np.broadcast_to(linear, (3, 2, 2)), atol=1e-8)


def test_dense_points_with_little_noise_give_the_field_back_to_a_hundredth_of_a_pixel():
    grid = np.meshgrid(np.arange(0, 600, 8.0), np.arange(0, 400, 8.0))
    points = np.stack(grid, axis=-1).reshape(-1, 2)
    noisy = curved(points) + np.random.default_rng(1).normal(0, 0.02, points.shape)
    for smoothing in (None, 1e-3):
        warp = fit_warp(points, noisy, extent=EXTENT, spacing=20.0, smoothing=smoothing)
        # an average of the noise of some six points per coefficient, and of nothing else
        assert np.median(misfit(warp, curved, probe())) < 0.01
        assert misfit(warp, curved, probe()).max() < 0.06


def test_smoothing_that_predicts_best_beats_too_little_and_too_much():
    points = scattered(900)
    noisy = curved(points) + np.random.default_rng(2).normal(0, 0.5, points.shape)
    errors = {
        smoothing: np.median(
            misfit(
                fit_warp(points, noisy, extent=EXTENT, spacing=25.0, smoothing=smoothing),
                curved,
                probe(),
            )
        )
        for smoothing in (None, 1e-5, 100.0)
    }
    assert errors[None] < 0.7 * min(errors[1e-5], errors[100.0])


def test_left_out_distances_agree_with_leaving_points_out():
    points = scattered(60, seed=3)
    noisy = curved(points) + np.random.default_rng(3).normal(0, 0.3, points.shape)
    settings = {"extent": EXTENT, "spacing": 80.0, "smoothing": 0.01}
    fit = fit_warp_checked(points, noisy, **settings)
    for k in (4, 31, 55):
        others = np.arange(len(points)) != k
        without = fit_warp(points[others], noisy[others], **settings)
        distance = np.linalg.norm(warp_points(without, points[k : k + 1])[0] - noisy[k])
        # robust weights and the density of points change a little when a point leaves
        assert_allclose(fit.left_out[k], distance, rtol=0.15)


def test_wild_pairs_do_not_bend_the_warp():
    points = scattered(1500)
    targets = curved(points)
    targets[::20] += np.random.default_rng(4).uniform(-60, 60, (75, 2))
    warp = fit_warp(points, targets, extent=EXTENT, spacing=40.0, smoothing=None)
    assert np.percentile(misfit(warp, curved, probe()), 99) < 0.3


def test_hole_in_the_data_is_bridged_and_rim_continued():
    points = scattered(3000)
    hole = np.linalg.norm(points - [220, 200], axis=1) < 60
    inside = (points[:, 0] < 500) & ~hole
    warp = fit_warp(
        points[inside], curved(points[inside]), extent=EXTENT, spacing=30.0, smoothing=None
    )
    bridged = probe()[np.linalg.norm(probe() - [220, 200], axis=1) < 60]
    assert misfit(warp, curved, bridged).max() < 1.0
    beyond = probe()[probe()[:, 0] > 500]
    distance = beyond[:, 0] - 500
    # curvature of the field: 12 / 90^2 per px in x
    assert (misfit(warp, curved, beyond) < 0.5 + 0.5 * 1.3 * 12 / 90**2 * distance**2).all()


def test_kink_does_not_ring_far():
    points = np.stack(np.meshgrid(np.arange(0, 600, 8.0), np.arange(0, 400, 8.0)), -1)
    points = points.reshape(-1, 2)
    noisy = kinked(points) + np.random.default_rng(5).normal(0, 0.02, points.shape)
    spacing = 20.0
    warp = fit_warp(points, noisy, extent=EXTENT, spacing=spacing, smoothing=1e-3)
    error, away = misfit(warp, kinked, probe()), np.abs(probe()[:, 0] - 300)
    assert error.max() < 0.1 * 0.6 * spacing + 0.3
    assert error[away > 3 * spacing].max() < 0.1
    assert error[away > 5 * spacing].max() < 0.05


def test_weights_say_whom_to_believe():
    points = scattered(1200)
    good = np.arange(len(points)) % 2 == 0
    targets = curved(points) + np.where(good[:, None], 0.0, [0.6, 0.0])
    weights = np.where(good, 1.0, 1e-4)
    settings = {"extent": EXTENT, "spacing": 40.0, "smoothing": 0.01}
    believed = fit_warp(points, targets, weights=weights, **settings)
    averaged = fit_warp(points, targets, **settings)
    assert np.median(misfit(believed, curved, probe())) < 0.05
    assert_allclose(np.median(misfit(averaged, curved, probe())), 0.3, atol=0.05)


def test_upright_and_lying_pictures_are_treated_alike():
    points = scattered(500)
    lying = fit_warp(points, curved(points), extent=EXTENT, spacing=40.0, smoothing=0.01)
    upright = fit_warp(
        points[:, ::-1],
        curved(points)[:, ::-1],
        extent=(EXTENT[0][::-1], EXTENT[1][::-1]),
        spacing=40.0,
        smoothing=0.01,
    )
    assert_allclose(
        warp_points(upright, probe()[:, ::-1])[0][:, ::-1],
        warp_points(lying, probe())[0],
        atol=1e-8,
    )


def test_points_with_nan_are_left_out():
    points = scattered(300)
    targets = curved(points)
    spoilt = targets.copy()
    spoilt[::7] = np.nan
    settings = {"extent": EXTENT, "spacing": 60.0, "smoothing": 0.01}
    clean = np.isfinite(spoilt).all(axis=1)
    assert_allclose(
        fit_warp(points, spoilt, **settings).coefficients,
        fit_warp(points[clean], targets[clean], **settings).coefficients,
    )


@pytest.mark.parametrize(
    ("points", "words"),
    [
        (np.array([[0.0, 0.0], [1.0, 1.0]]), "at least 3 pairs"),
        (np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [5.0, 5.0]]), "in one line"),
    ],
)
def test_too_little_to_fix_a_warp_is_an_error(points, words):
    with pytest.raises(DataError, match=words):
        fit_warp(points, points, extent=EXTENT, spacing=50.0, smoothing=None)


def test_fold_share_counts_what_is_turned_over():
    points = np.stack(np.meshgrid(np.arange(0, 601, 20.0), np.arange(0, 401, 20.0)), -1)
    points = points.reshape(-1, 2)
    folded = points.copy()
    folded[:, 0] = np.where(points[:, 0] < 450, points[:, 0], 900 - points[:, 0])
    settings = {"extent": EXTENT, "spacing": 40.0, "smoothing": 1e-4}
    mask = np.ones((400, 600), bool)
    sound = fit_warp(points, points, **settings)
    bent = fit_warp(points, folded, **settings)
    assert fold_share(sound, mask, points, reach=30.0) == 0
    assert_allclose(fold_share(bent, mask, points, reach=30.0), 0.25, atol=0.03)
