"""Small systems against numpy, warps against what they do to points."""

import numpy as np
import pytest
from numba import njit
from numpy.testing import assert_allclose

from shapemorph.kernels import small_linear


@njit
def factor(matrix, count, damping, lower):
    return small_linear.factor(matrix, count, damping, lower)


@njit
def solve(lower, right, count, solution):
    small_linear.solve(lower, right, count, solution)


@njit
def compose_with_inverse(warp, step, second, result):
    small_linear.compose_with_inverse(warp, step, second, result)


IDENTITY = np.array([0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0], dtype=float)


def _apply(warp, x, y):
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    return warp[:6] @ terms, warp[6:] @ terms


def _random_matrix(size, seed):
    root = np.random.default_rng(seed).normal(size=(size, size))
    return root @ root.T + 0.1 * np.eye(size)


def test_factor_and_solve_agree_with_numpy():
    matrix, right = _random_matrix(7, 0), np.arange(7.0)
    lower, solution = np.zeros((9, 9)), np.zeros(9)
    assert factor(matrix, 7, 0.0, lower)
    solve(lower, right, 7, solution)
    assert_allclose(solution[:7], np.linalg.solve(matrix, right), rtol=1e-9)


def test_damping_raises_the_diagonal():
    matrix, right = _random_matrix(5, 1), np.ones(5)
    lower, solution = np.zeros((5, 5)), np.zeros(5)
    factor(matrix, 5, 0.3, lower)
    solve(lower, right, 5, solution)
    raised = matrix + 0.3 * np.diag(np.diag(matrix))
    assert_allclose(solution, np.linalg.solve(raised, right), rtol=1e-10)


def test_a_singular_matrix_is_refused():
    column = np.array([[1.0, 2.0, 3.0]])
    assert not factor(column.T @ column, 3, 0.0, np.zeros((3, 3)))


def test_affine_composition_undoes_the_step_exactly():
    rng = np.random.default_rng(2)
    warp, step, result = IDENTITY.copy(), np.zeros(12), np.zeros(12)
    warp[[0, 1, 2, 6, 7, 8]] += rng.normal(0, 0.4, 6)
    step[[0, 1, 2, 6, 7, 8]] = rng.normal(0, 0.2, 6)
    compose_with_inverse(warp, step, None, result)
    x, y = rng.normal(0, 5, (2, 30))
    assert_allclose(_apply(result, *_apply(IDENTITY + step, x, y)), _apply(warp, x, y), atol=1e-11)


@pytest.mark.parametrize("seed", [3, 4])
def test_second_order_composition_lacks_only_terms_of_third_degree(seed):
    rng = np.random.default_rng(seed)
    curve, result = np.zeros(12), np.zeros(12)
    curve[[3, 4, 5, 9, 10, 11]] = rng.normal(0, 0.05, 6)
    step = rng.normal(0, 1e-3, 12)
    compose_with_inverse(IDENTITY + curve, step, 1, result)
    x, y = rng.normal(0, 1, (2, 50))
    errors = []
    for reach in (1.0, 0.5):
        back = _apply(result, *_apply(IDENTITY + step, reach * x, reach * y))
        wanted = _apply(IDENTITY + curve, reach * x, reach * y)
        errors.append(np.abs(np.subtract(back, wanted)).max())
    assert errors[0] < 2e-2  # the step times the third power of 2.7
    assert errors[1] < errors[0] / 6.0  # eight for third degree, four if a second were wrong
