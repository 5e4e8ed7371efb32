"""Parts of the library that need no measurement."""

import numpy as np
import pytest

import shapemorph as sm
from shapemorph.core.errors import DataError
from shapemorph.io.quantities import FACET_ARRAYS


def test_triangles_that_are_known_twice_have_their_stretches_in_every_measure():
    rng = np.random.default_rng(1)
    nodes = rng.normal(size=(40, 3)) * [10, 10, 0]
    faces = np.array([[a, a + 1, a + 2] for a in range(38)])
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    found = sm.facet_strain(nodes, nodes @ np.diag([3.0, 0.5, 1.0]) @ turn + 7, faces)
    assert set(found) == set(FACET_ARRAYS)
    np.testing.assert_allclose(found["stretch_1"], 3.0, atol=1e-9)
    np.testing.assert_allclose(found["engineering_2"], -0.5, atol=1e-9)
    np.testing.assert_allclose(found["area_ratio"], 1.5, atol=1e-9)


@pytest.mark.parametrize(
    ("moved", "faces", "message"),
    [
        (np.zeros((3, 3)), [[0, 1, 2]], r"\(4, 3\) and \(3, 3\)"),
        (np.zeros((4, 3)), [[0, 1]], r"faces \(F, 3\)"),
        (np.zeros((4, 3)), [[0.0, 1.0, 2.0]], "whole numbers"),
        (np.zeros((4, 3)), [[0, 1, 4]], "vertices 0 to 3, got 4"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(moved, faces, message):
    with pytest.raises(DataError, match=message):
        sm.facet_strain(np.zeros((4, 3)), moved, np.array(faces))
