"""Small systems are factorised, large ones iterated, and both ways agree."""

import numpy as np
import pytest
from scipy.sparse import csc_array, diags_array

from shapemorph.methods.parametrize import symmetric_solve
from shapemorph.methods.parametrize.symmetric_solve import symmetric_solver


def chain(size):
    """Laplacian of a chain whose ends are held: its inverse is known on paper."""
    return csc_array(diags_array([-1.0, 2.0, -1.0], offsets=[-1, 0, 1], shape=(size, size)))


@pytest.mark.parametrize("most", [0, 10**6])
def test_a_hanging_chain_is_a_parabola(monkeypatch, most):
    monkeypatch.setattr(symmetric_solve, "MOST_FACTORISED", most)
    size = 2000
    place = np.arange(1, size + 1)
    found = symmetric_solver(chain(size))(np.ones((size, 2)))
    expected = place * (size + 1 - place) / 2
    np.testing.assert_allclose(found, np.stack([expected, expected], axis=1), rtol=1e-6)


def test_where_the_iteration_stalls_the_system_is_factorised(monkeypatch):
    monkeypatch.setattr(symmetric_solve, "MOST_FACTORISED", 0)
    monkeypatch.setattr(symmetric_solve, "multilevel_solver", lambda *_: lambda _: None)
    np.testing.assert_allclose(symmetric_solver(chain(3))(np.ones(3)), [1.5, 2.0, 1.5])
