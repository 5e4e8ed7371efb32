"""Vectors of compiled loops against numpy."""

import numpy as np
import pytest
from numba import njit
from numpy.testing import assert_allclose

from shapemorph.kernels.vectors import (
    LANES,
    choose,
    fused,
    gather,
    load,
    spread,
    store,
    total,
    whole,
)

LEFT = np.random.default_rng(0).normal(0, 3, 2 * LANES).astype(np.float32)
RIGHT = np.random.default_rng(1).normal(0, 3, 2 * LANES).astype(np.float32)


@njit
def _arithmetic(left, right):
    a, b = load(left, 1), load(right, 2)
    return total(a + b), total(a - b), total(a * b), total(fused(a, b, spread(2)))


@njit
def _choices(left, right):
    a, b = load(left, 0), load(right, 0)
    return total(choose(a, b, a, b)), total(whole(a))


@njit
def _gathered(array, rows, cols, used):
    row, col = load(rows, 0), load(cols, 0)
    return total(gather(array, array.shape[1], array.shape[1], row, col, load(used, 0)))


@njit
def _doubled(array):
    store(array, 1, load(array, 0) * spread(2))


def test_a_vector_is_written_to_its_own_elements_alone():
    array = np.arange(2 * LANES, dtype=np.float32)
    wanted = array.copy()
    wanted[1 : LANES + 1] = 2 * array[:LANES]
    _doubled(array)
    assert (array == wanted).all()


def test_arithmetic_goes_lane_by_lane():
    a, b = LEFT[1 : LANES + 1].astype(float), RIGHT[2 : LANES + 2].astype(float)
    wanted = (a + b).sum(), (a - b).sum(), (a * b).sum(), (a * b + 2).sum()
    assert_allclose(_arithmetic(LEFT, RIGHT), wanted, rtol=1e-5)


def test_choices_go_lane_by_lane():
    a, b = LEFT[:LANES], RIGHT[:LANES]
    assert_allclose(_choices(LEFT, RIGHT), (np.maximum(a, b).sum(), np.floor(a).sum()), rtol=1e-5)


def test_unused_lanes_read_nothing():
    rng = np.random.default_rng(2)
    array = rng.normal(0, 1, (6, 9)).astype(np.float32)
    row, col = rng.integers(0, 4, LANES), rng.integers(0, 9, LANES)
    used = (np.arange(LANES) % 3 > 0).astype(np.float32)
    wanted = array[row + 1, col][used > 0].sum()
    row[used == 0] = 10**6  # far beyond the array
    found = _gathered(array, row.astype(np.float32), col.astype(np.float32), used)
    assert found == pytest.approx(wanted, rel=1e-5)
