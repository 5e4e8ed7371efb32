"""Local quadratic surfaces on a grid."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.methods.grid_smoothing import GridSmoother, bends, fill_gaps


def _quadratic():
    rows, cols = np.mgrid[:20, :26].astype(float)
    return (1 + 0.3 * rows - 0.2 * cols + 0.02 * rows * cols - 0.01 * cols**2)[..., None]


@pytest.mark.parametrize("reach", [1.2, 4.0])
def test_a_local_quadratic_fit_reproduces_a_quadratic_to_the_rim(reach):
    known = np.ones((20, 26), dtype=bool)
    known[5:8, 9] = False
    smoother = GridSmoother.over(known.astype(float), reach=reach)
    assert smoother.sound.all()
    assert_allclose(smoother(_quadratic()), _quadratic(), atol=2e-3)  # a ridge of 1e-6


def test_a_fit_ends_where_there_is_nothing_near():
    known = np.zeros((20, 40), dtype=bool)
    known[:, :10] = True
    smoother = GridSmoother.over(known.astype(float), reach=2.0)
    assert smoother.sound[:, :12].all()
    assert not smoother.sound[:, 16:].any()
    assert not smoother(np.full((20, 40, 1), np.nan))[:, 16:].any()


def test_bends_of_a_quadratic_are_its_terms_of_second_order():
    inner = bends(_quadratic())[1:-1, 1:-1, 0]
    assert_allclose(inner, np.broadcast_to([-0.01, 0.02, 0.0], inner.shape), atol=1e-12)


def test_gaps_are_filled_with_what_is_near():
    values, known = np.zeros((12, 15, 2)), np.zeros((12, 15), dtype=bool)
    values[:, :3], known[:, :3] = [1.0, 2.0], True
    values[~known] = np.nan
    assert_allclose(fill_gaps(values, known), np.broadcast_to([1.0, 2.0], (12, 15, 2)), atol=1e-9)
