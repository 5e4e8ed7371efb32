"""Passes over sparse rows do what dense algebra says."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from shapemorph.kernels import sparse

COUNT = 40


def system(kind):
    random = np.random.default_rng(2)
    dense = random.normal(size=(COUNT, COUNT)) * (random.random((COUNT, COUNT)) < 0.15)
    dense = dense + dense.T + 30 * np.eye(COUNT)
    matrix = csr_array(dense)
    matrix.sort_indices()
    rows = (matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32), matrix.data)
    right = random.normal(size=COUNT).astype(kind)
    if kind is np.complex128:
        right = right + 1j * random.normal(size=COUNT)
    return dense, rows, right


@pytest.mark.parametrize("kind", [np.float64, np.complex128])
def test_products_are_those_of_dense_matrices(kind):
    dense, rows, right = system(kind)
    out = np.full(COUNT, np.nan, dtype=kind)
    sparse.multiply(*rows, right, out)
    np.testing.assert_allclose(out, dense @ right)
    sparse.add_product(*rows, right, out)
    np.testing.assert_allclose(out, 2 * dense @ right)


@pytest.mark.parametrize("kind", [np.float64, np.complex128])
def test_sweeps_solve_with_the_triangles(kind):
    dense, rows, right = system(kind)
    x, rest = np.empty(COUNT, dtype=kind), np.empty(COUNT, dtype=kind)
    sparse.sweep_down(*rows, right, x, rest)
    np.testing.assert_allclose(x, np.linalg.solve(np.tril(dense), right))
    np.testing.assert_allclose(rest, right - dense @ x, atol=1e-12)
    expected = x + np.linalg.solve(np.triu(dense), rest)
    sparse.sweep_up(*rows, np.diag(dense).copy(), right, x)
    np.testing.assert_allclose(x, expected)


def test_the_dot_of_pairs_is_the_sum_of_both():
    one, other = np.array([1 + 2j, 3 - 1j]), np.array([2 - 1j, 4 + 5j])
    assert sparse.dot(one, other) == 2 - 2 + 12 - 5


def test_groups_are_connected_and_leave_nobody_out():
    _, rows, _ = system(np.float64)
    count, group = sparse.aggregate(*rows[:2])
    assert set(group.tolist()) == set(range(count))
    assert count < COUNT / 2
    starts, columns = rows[:2]
    for i in range(COUNT):
        beside = group[columns[starts[i] : starts[i + 1]]]
        assert (beside == group[i]).sum() > 1  # itself and a neighbour
