from types import SimpleNamespace

import numpy as np
import pytest

from shapemorph.methods.vertex_averaging import (
    averaged_noise,
    count_in_squares,
    leverage_of_cut_subsets,
    pattern_grain,
)


def test_count_agrees_with_looking_at_every_point():
    rng = np.random.default_rng(22)
    scattered = rng.uniform([-20, 5], [80, 45], (3000, 2))
    centres = rng.uniform([-30, 0], [90, 50], (40, 2)).round()
    widths = rng.choice([6.0, 10, 20], 40)
    low, high = centres - widths[:, None] / 2, centres + widths[:, None] / 2
    inside = (scattered >= low[:, None]) & (scattered < high[:, None])
    found = count_in_squares(scattered, centres, widths)
    np.testing.assert_array_equal(found, inside.all(axis=2).sum(axis=1))


def test_four_times_the_vertices_halve_the_noise():
    x, y = np.meshgrid(np.arange(0, 100, 0.5), np.arange(0, 80, 0.5))
    fine = np.stack([x, y], axis=-1)
    centres, width = np.array([[50.0, 40.0]]), np.array([32.0])
    noises = [
        averaged_noise(vertices.reshape(-1, 2), centres, width, vertex_noise=0.01)
        for vertices in (fine, fine[::2, ::2])
    ]
    np.testing.assert_allclose(noises[0], noises[1] / 2, rtol=1e-12)


def test_grain_is_the_noise_of_matches_times_the_width_of_their_subset():
    def side(scale, noise):
        x, y = np.meshgrid(np.arange(0, 120 * scale, 2.0), np.arange(0, 80 * scale, 2.0))
        vertices = np.stack([x, y], axis=-1).reshape(-1, 2)
        chart = SimpleNamespace(vertex_px=vertices, px_per_mm=10.0 * scale)
        mask = np.ones((int(80 * scale), int(120 * scale)), dtype=bool)
        width = np.array([20.0 * scale])
        middle = np.array([[60.0, 40.0]]) * scale
        match = averaged_noise(vertices, middle, width, vertex_noise=noise)[0] * 10.0
        return SimpleNamespace(chart=chart, image=SimpleNamespace(mask=mask)), match

    sides, matches = zip(side(1, 0.006), side(2, 0.01), strict=True)  # px of the first picture
    found = pattern_grain(*sides, (0.006, 0.01))
    np.testing.assert_allclose(found / 20.0, np.hypot(*matches), rtol=1e-9)


def test_lost_point_has_no_noise_and_empty_square_claims_one_vertex():
    centres = np.array([[np.nan, np.nan], [500.0, 500.0]])
    found = averaged_noise(np.zeros((4, 2)), centres, np.full(2, 10.0), vertex_noise=0.01)
    assert np.isnan(found[0])
    assert found[1] >= 0.01


def test_a_cut_subset_is_as_noisy_as_a_plane_through_noise_at_its_point():
    rng = np.random.default_rng(23)
    mask = np.zeros((60, 60), dtype=bool)
    mask[:, 30:] = True
    mask[50:, 35:] = False
    points = np.array([[30, 25], [34, 20], [33, 48], [45, 25], [2, 2], [-50, 900]])
    found = leverage_of_cut_subsets(mask, points, 19)
    noise = rng.normal(size=(4000, 19 * 19))
    y, x = np.mgrid[-9:10, -9:10]
    for (column, row), gain in zip(points[:3], found[:3], strict=True):
        left = mask[row - 9 : row + 10, column - 9 : column + 10].ravel()
        plane = np.stack([np.ones(19 * 19), x.ravel(), y.ravel()], axis=1)[left]
        at_point = np.linalg.pinv(plane)[0] @ noise[:, left].T
        mean = noise[:, left].mean(axis=1)
        np.testing.assert_allclose(gain, at_point.std() / mean.std(), rtol=0.05)
    np.testing.assert_array_equal(found[3:], 1.0)
    assert found[0] == pytest.approx(2.0, rel=0.1)
