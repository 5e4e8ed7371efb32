"""Warps evaluated against a map that a cubic spline holds exactly."""

import numpy as np
from numpy.testing import assert_allclose

from shapemorph.core.matching import Warp
from shapemorph.methods.warping import warp_points


def _affine_warp(matrix, shift, origin, spacing):
    rows, cols = np.mgrid[0:8, 0:11].astype(float)
    nodes = origin + spacing * np.stack([cols, rows], axis=-1)
    return Warp(nodes @ matrix.T + shift, origin, spacing)


def test_affine_map_is_exact_with_origin_and_spacing():
    matrix, shift = np.array([[0.9, 0.2], [-0.3, 1.4]]), np.array([12.0, -7.0])
    warp = _affine_warp(matrix, shift, np.array([-20.0, -11.0]), 7.5)
    points = np.random.default_rng(3).uniform([-10, -2], [45, 30], size=(40, 2))
    targets, gradient = warp_points(warp, points)
    assert_allclose(targets, points @ matrix.T + shift, atol=1e-10)
    assert_allclose(gradient, np.broadcast_to(matrix, (40, 2, 2)), atol=1e-12)


def test_outside_its_extent_a_warp_says_nothing():
    warp = _affine_warp(np.eye(2), np.zeros(2), np.zeros(2), 5.0)
    targets, gradient = warp_points(warp, np.array([[-1.0, 20.0]]))
    assert np.isnan(targets).all()
    assert np.isnan(gradient).all()
