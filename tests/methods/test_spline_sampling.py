"""Splines at many points: the blocks leave no trace."""

import numpy as np
from numpy.testing import assert_array_equal

from shapemorph.methods.spline_sampling import BLOCK, sample_vectors
from shapemorph.methods.threads import kernel_threads


def test_blocks_and_threads_change_nothing():
    rng = np.random.default_rng(0)
    control = rng.normal(size=(9, 12, 2))
    points = rng.uniform(0, 12, (BLOCK + 300, 2))
    with kernel_threads(1):
        values, gradients = sample_vectors(control, points)
    again, slopes = sample_vectors(control, points)
    assert_array_equal(again, values)
    assert_array_equal(slopes, gradients)
    some = sample_vectors(control.copy(order="F"), points[BLOCK - 7 : BLOCK + 9])
    assert_array_equal(some[0], values[BLOCK - 7 : BLOCK + 9])
    assert_array_equal(some[1], gradients[BLOCK - 7 : BLOCK + 9])
