"""Components agree with an independent implementation, numbers included."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapemorph.kernels.components import connect


@pytest.mark.parametrize(("nodes", "links"), [(1, 0), (7, 3), (200, 90), (500, 2000)])
def test_labels_are_those_of_scipy(nodes, links):
    one, other = np.random.default_rng(nodes).integers(0, nodes, (2, links))
    graph = coo_array((np.ones(links), (one, other)), shape=(nodes, nodes))
    expected = connected_components(graph, directed=False)
    count, label = connect(one, other, nodes)
    assert count == expected[0]
    np.testing.assert_array_equal(label, expected[1])
