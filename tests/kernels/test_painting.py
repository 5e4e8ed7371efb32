"""Painting loops against closed forms and brute force."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import distance_transform_cdt

from shapemorph.kernels.painting import cover, paint, speckle_at, spread

ORIGIN, CELL = np.array([-1.0, 2.0]), np.array([1.5, 1.1])


def _blobs(rows=7, cols=9):
    rng = np.random.default_rng(8)
    return np.concatenate([rng.random((rows, cols, 2)), rng.uniform(0.3, 0.5, (rows, cols, 1))], 2)


def _brute_force(points, blobs, edge):
    """Every blob of the lattice and of its eight repetitions."""
    rows, cols = blobs.shape[:2]
    bright = np.ones(len(points))
    for j in range(-rows, 2 * rows):
        for i in range(-cols, 2 * cols):
            x, y, radius = blobs[j % rows, i % cols]
            centre = ORIGIN + np.array([i + x, j + y]) * CELL
            t = (np.linalg.norm(points - centre, axis=1) - radius) / edge + 0.5
            t = np.clip(t, 0, 1)
            bright *= t * t * (3 - 2 * t)
    return bright


def test_speckle_agrees_with_looking_at_every_blob():
    blobs, edge = _blobs(), 0.3
    points = ORIGIN + np.random.default_rng(1).uniform(0, 1, (3000, 2)) * CELL * [9, 7]
    expected = _brute_force(points, blobs, edge)
    assert_allclose(speckle_at(points, blobs, ORIGIN, CELL, edge), expected, atol=1e-12)
    assert 0.2 < expected.mean() < 0.8


def test_the_lattice_repeats():
    blobs = _blobs()
    points = ORIGIN + np.random.default_rng(2).uniform(0, 9, (500, 2))
    period = CELL * [9, 7]
    here = speckle_at(points, blobs, ORIGIN, CELL, 0.2)
    for shift in (period * [1, 0], period * [0, -2]):
        assert_allclose(speckle_at(points + shift, blobs, ORIGIN, CELL, 0.2), here, atol=1e-9)


def test_cover_finds_the_triangle_under_each_centre():
    corners = np.array(
        [[[1.0, 1.0], [9.0, 2.0], [2.0, 7.0]], [[9.0, 2.0], [10.0, 8.0], [2.0, 7.0]]]
    )
    face = cover(corners, 11, 13)
    assert face.shape == (11, 13)
    assert face[3, 3] == 0  # row 3 = y, column 3 = x
    assert face[6, 8] == 1
    assert face[1, 12] == face[9, 9] == -1
    area = 0.5 * abs(8 * 6 - 1 * 1) + 0.5 * abs(1 * 5 - (-7) * 6)
    assert (face >= 0).sum() == pytest.approx(area, abs=6)  # half a texel along the outline


def test_cover_leaves_what_is_outside_the_picture():
    corners = np.array([[[-5.0, -5.0], [30.0, -5.0], [-5.0, 30.0]]])
    assert (cover(corners, 6, 8) == 0).all()


def test_spread_reaches_as_far_as_it_may_and_takes_filled_texels():
    filled = np.zeros((20, 31), dtype=bool)
    filled[9:12, 8:20] = True
    source = spread(filled, 4)
    steps = distance_transform_cdt(~filled, metric="taxicab")
    assert np.array_equal(source >= 0, steps <= 4)
    assert filled.ravel()[source[source >= 0]].all()
    assert np.array_equal(source[filled], np.flatnonzero(filled))


def test_paint_carries_material_through_a_curved_face():
    """A face whose nodes follow a known quadratic map shows the speckle of that map."""

    def material_of(x, y):
        return np.stack([0.3 * x + 0.002 * x * y, 3 + 0.1 * y - 0.003 * x**2], axis=-1)

    corners = np.array([[[2.0, 1.0], [27.0, 4.0], [5.0, 22.0]]])
    middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
    places = np.concatenate([corners, middles], axis=1)
    nodes = material_of(places[..., 0], places[..., 1])
    face = cover(corners, 25, 30)
    blobs, edge = _blobs(), 0.4
    bright, material = paint(face, corners, nodes, blobs, ORIGIN, CELL, edge, 1)
    rows, cols = np.nonzero(face == 0)
    expected = material_of(cols.astype(float), rows.astype(float))
    assert_allclose(material[rows, cols], expected, atol=1e-10)
    direct = speckle_at(expected, blobs, ORIGIN, CELL, edge)
    assert_allclose(bright[rows, cols], direct, atol=1e-6)  # stored in single precision
    assert np.isnan(bright[face < 0]).all()


def test_paint_averages_over_the_texel():
    corners = np.array([[[0.0, 0.0], [20.0, 0.0], [0.0, 20.0]]])
    places = np.concatenate([corners, 0.5 * (corners + np.roll(corners, -1, axis=1))], axis=1)
    face = np.where(np.add.outer(np.arange(20), np.arange(20)) < 15, 0, -1)
    blobs = _blobs()
    coarse, _ = paint(face, corners, places, blobs, ORIGIN, CELL, 0.2, 8)
    offsets = (np.arange(40) + 0.5) / 40 - 0.5
    texel = np.array([6.0, 5.0]) + np.stack(np.meshgrid(offsets, offsets), -1).reshape(-1, 2)
    mean = speckle_at(texel, blobs, ORIGIN, CELL, 0.2).mean()
    assert coarse[5, 6] == pytest.approx(mean, abs=0.02)  # 64 samples against 1600
