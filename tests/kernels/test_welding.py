"""Groups of close points agree with a tree search, wherever the points lie."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from shapemorph.kernels.welding import weld_along


def expected_groups(points, tolerance):
    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(points),) * 2)
    return connected_components(links, directed=False)


@pytest.mark.parametrize("tolerance", [1e-9, 0.02, 0.2])
def test_chains_of_close_points_are_one(tolerance):
    random = np.random.default_rng(5)
    points = random.random((300, 3))
    points = np.concatenate([points, points[::2], points[::3] + 1e-10])[random.permutation(550)]
    place = points @ np.array([0.6, 0.0, 0.8])
    count, group = weld_along(points, place, np.argsort(place, kind="stable"), tolerance)
    wanted = expected_groups(points, tolerance)
    assert count == wanted[0]
    np.testing.assert_array_equal(group, wanted[1])


def test_many_points_at_one_place_take_no_longer_than_their_number():
    points = np.zeros((300_000, 3))
    count, group = weld_along(points, np.zeros(300_000), np.arange(300_000), 1e-6)
    assert count == 1
    assert not group.any()
