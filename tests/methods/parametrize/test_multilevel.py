"""The iteration finds what a factorisation finds, in few steps, also where triangles are poor."""

import igl
import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from shapemorph.methods.parametrize import multilevel
from shapemorph.methods.parametrize.multilevel import multilevel_solver


def factorised(matrix):
    return splu(matrix.tocsc()).solve


def laplacian(points, squeeze):
    """Cotangent Laplacian of a bumpy grid with its rim held."""
    x, y = np.meshgrid(np.linspace(0, 1, points), np.linspace(0, 1, points))
    jitter = np.random.default_rng(1).normal(size=(2, points, points)) * 0.2 / points
    height = 0.3 * np.sin(5 * x) * np.cos(4 * y)
    vertices = np.stack([x + jitter[0], (y + jitter[1]) * squeeze, height], -1).reshape(-1, 3)
    index = np.arange(points**2).reshape(points, points)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    faces = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    inner = index[1:-1, 1:-1].ravel()
    return csr_array((-igl.cotmatrix(vertices, faces)).tocsr()[inner][:, inner])


@pytest.mark.parametrize("columns", [None, 1, 2, 3])
def test_solutions_are_those_of_a_factorisation(monkeypatch, columns):
    monkeypatch.setattr(multilevel, "COARSEST", 200)
    matrix = laplacian(70, 1.0)
    shape = matrix.shape[:1] if columns is None else (matrix.shape[0], columns)
    right = np.random.default_rng(0).normal(size=shape)
    found = multilevel_solver(matrix, factorised)(right)
    expected = factorised(matrix)(right)
    assert found.shape == right.shape
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())


def test_long_triangles_only_take_more_steps(monkeypatch):
    monkeypatch.setattr(multilevel, "COARSEST", 200)
    matrix = laplacian(50, 0.2)
    right = np.ones(matrix.shape[0])
    found = multilevel_solver(matrix, factorised)(right)
    expected = factorised(matrix)(right)
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())


def test_a_system_that_is_not_definite_is_given_back(monkeypatch):
    monkeypatch.setattr(multilevel, "COARSEST", 200)
    matrix = csr_array(laplacian(30, 1.0) * -1.0)
    assert multilevel_solver(matrix, factorised)(np.ones(matrix.shape[0])) is None
