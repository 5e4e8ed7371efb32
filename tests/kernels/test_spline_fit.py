import numpy as np
from numpy.testing import assert_allclose

from shapemorph.kernels import spline_fit

HEIGHT, WIDTH = 7, 5


def dense(band):
    """The full symmetric matrix of a lower band."""
    size, half = band.shape[0], band.shape[1] - 1
    matrix = np.zeros((size, size))
    for i in range(size):
        for j in range(max(0, i - half), i + 1):
            matrix[i, j] = matrix[j, i] = band[i, half - (i - j)]
    return matrix


def points(count=60):
    return np.random.default_rng(0).uniform(1, [WIDTH - 2, HEIGHT - 2], (count, 2))


def design(first, weights):
    matrix = np.zeros((len(first), HEIGHT * WIDTH))
    for k in range(len(first)):
        for a in range(16):
            matrix[k, first[k] + (a // 4) * WIDTH + a % 4] = weights[k, a]
    return matrix


def system():
    first, weights = spline_fit.basis(points(), HEIGHT, WIDTH)
    importance = np.random.default_rng(1).uniform(0.5, 2, len(first))
    values = np.random.default_rng(2).normal(size=(len(first), 2))
    band, right = spline_fit.data_equations(first, weights, importance, values, HEIGHT, WIDTH)
    return first, weights, importance, values, band, right


def test_basis_reproduces_linear_fields():
    first, weights = spline_fit.basis(points(), HEIGHT, WIDTH)
    rows, cols = np.mgrid[:HEIGHT, :WIDTH]
    field = (2.0 * cols - 3.0 * rows + 1.0).ravel()
    expected = 2.0 * points()[:, 0] - 3.0 * points()[:, 1] + 1.0
    assert_allclose(design(first, weights) @ field, expected, atol=1e-12)


def test_data_equations_are_those_of_weighted_least_squares():
    first, weights, importance, values, band, right = system()
    matrix = design(first, weights)
    assert_allclose(dense(band), matrix.T @ (importance[:, None] * matrix), atol=1e-12)
    assert_allclose(right, matrix.T @ (importance[:, None] * values), atol=1e-12)


def test_bending_is_the_sum_of_squared_second_differences():
    field = np.random.default_rng(3).normal(size=(HEIGHT, WIDTH))
    expected = (np.diff(field, 2, axis=0) ** 2).sum() + (np.diff(field, 2, axis=1) ** 2).sum()
    expected += 2 * (np.diff(np.diff(field, axis=0), axis=1) ** 2).sum()
    matrix = dense(spline_fit.bending_equations(HEIGHT, WIDTH))
    assert_allclose(field.ravel() @ matrix @ field.ravel(), expected)


def test_factor_solves_and_gives_leverages():
    first, weights, _importance, _values, band, right = system()
    band = band + 0.1 * spline_fit.bending_equations(HEIGHT, WIDTH)
    factor = spline_fit.factorise(band)
    matrix = dense(band)
    assert_allclose(spline_fit.solve(factor, right), np.linalg.solve(matrix, right), atol=1e-9)
    rows = design(first, weights)
    expected = np.einsum("ni,ij,nj->n", rows, np.linalg.inv(matrix), rows)
    assert_allclose(spline_fit.leverages(factor, first, weights, WIDTH), expected, atol=1e-10)


def test_matrix_that_is_not_positive_definite_gives_nan():
    assert np.isnan(spline_fit.factorise(-np.ones((4, 2)))).any()
