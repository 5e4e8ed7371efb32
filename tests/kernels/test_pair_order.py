"""Pairs come out as a stable sort would have them, crowds of one first number included."""

import numpy as np
import pytest

from shapemorph.kernels.pair_order import FEW, order_pairs, order_sides


@pytest.mark.parametrize("values", [2, 10, 1000])
def test_the_order_is_that_of_a_lexical_sort(values):
    first, second = np.random.default_rng(values).integers(0, values, (2, 20 * FEW))
    np.testing.assert_array_equal(
        order_pairs(first, second, values), np.lexsort((np.arange(20 * FEW), second, first))
    )


def test_nothing_is_nothing():
    none = np.zeros(0, dtype=np.int64)
    assert len(order_pairs(none, none, 0)) == 0


def test_sides_of_one_edge_stand_together():
    faces = np.array([[0, 1, 2], [2, 1, 3], [1, 0, 4]])
    order, first = order_sides(faces, 5)
    edges = np.split(order, first[1:])
    # Sides 0 and 6 run along 0-1, 1 and 3 along 1-2; the others have no partner.
    assert [edge.tolist() for edge in edges] == [[0, 6], [2], [7], [1, 3], [4], [8], [5]]
