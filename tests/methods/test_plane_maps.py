"""Inverses of many maps."""

import numpy as np
from numpy.testing import assert_allclose

from shapemorph.methods.plane_maps import inverse_maps


def test_inverses_are_those_of_each_map_and_what_has_collapsed_has_none():
    maps = np.random.default_rng(0).normal(size=(5, 2, 2))
    maps[3] = [[1.0, 2.0], [2.0, 4.0]]
    found = inverse_maps(maps)
    sound = [0, 1, 2, 4]
    assert_allclose(found[sound], np.linalg.inv(maps[sound]), rtol=1e-12)
    assert not np.isfinite(found[3]).any()
