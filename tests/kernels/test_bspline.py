"""Spline sampling against an independent library and closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import BSpline
from scipy.ndimage import map_coordinates, spline_filter

from shapemorph.kernels.bspline import (
    cubic_slopes,
    cubic_weights,
    quintic_weights,
    sample,
)
from shapemorph.methods.spline_sampling import sample_vectors


def test_sample_agrees_with_scipy():
    rng = np.random.default_rng(2)
    coefficients = rng.normal(size=(40, 53))
    points = rng.uniform(2, 37, size=(500, 2))
    oracle = map_coordinates(coefficients, points.T[::-1], order=3, prefilter=False)
    assert_allclose(sample(coefficients, points), oracle, atol=1e-12)


def test_x_is_the_column():
    ramp = np.tile(np.arange(40.0), (30, 1))
    assert_allclose(sample(spline_filter(ramp), np.array([[17.0, 9.0]])), [17.0], atol=1e-6)


@pytest.mark.parametrize("outside", [(0.5, 5), (18, 5), (5, 8.5), (np.nan, 5)])
def test_outside_is_nan(outside):
    assert np.isnan(sample(np.ones((10, 20)), np.array([outside], dtype=float))).all()


@pytest.mark.parametrize("t", [0.0, 0.3, 0.999])
def test_weights_are_a_partition_of_unity_and_slopes_their_derivative(t):
    step = 1e-6
    numeric = (np.array(cubic_weights(t + step)) - np.array(cubic_weights(t - step))) / (2 * step)
    assert sum(cubic_weights(t)) == pytest.approx(1, abs=1e-14)
    assert_allclose(cubic_slopes(t), numeric, atol=1e-8)


@pytest.mark.parametrize("t", [0.0, 0.3, 0.999])
def test_quintic_weights_are_those_of_the_basis_spline(t):
    basis = BSpline.basis_element(np.arange(-3.0, 4.0))
    assert_allclose(quintic_weights(t), basis(t - np.arange(-2, 4)), atol=1e-14)


def test_vector_spline_reproduces_an_oblique_affine_map_and_its_gradient():
    rows, cols = np.mgrid[0:9, 0:12].astype(float)
    matrix, shift = np.array([[1.2, -0.4], [0.3, 0.8]]), np.array([5.0, -2.0])
    control = np.stack([cols, rows], axis=-1) @ matrix.T + shift
    points = np.random.default_rng(0).uniform([1, 1], [10, 7], size=(50, 2))
    values, gradients = sample_vectors(control, points)
    assert_allclose(values, points @ matrix.T + shift, atol=1e-12)
    assert_allclose(gradients, np.broadcast_to(matrix, (50, 2, 2)), atol=1e-12)


def test_vector_spline_reaches_the_last_interior_node():
    control = np.random.default_rng(1).normal(size=(6, 7, 2))
    edge = np.array([[5.0, 4.0], [5.0001, 4.0]])
    values, _ = sample_vectors(control, edge)
    assert np.isfinite(values[0]).all()
    assert np.isnan(values[1]).all()


def test_compiled_agrees_with_python():
    rng = np.random.default_rng(1)
    coefficients, points = rng.normal(size=(12, 14)), rng.uniform(1, 9, size=(20, 2))
    assert_allclose(sample(coefficients, points), sample.py_func(coefficients, points), rtol=1e-12)
