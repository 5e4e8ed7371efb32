import numpy as np

from shapemorph.methods.grid_average import average_over_window


def test_average_uses_only_what_is_known_and_fills_nothing():
    values = np.arange(20.0).reshape(4, 5, 1)
    values[1, 2] = np.nan
    found = average_over_window(values, window=3)
    assert np.isnan(found[1, 2, 0])
    np.testing.assert_allclose(found[0, 0, 0], np.mean([0, 1, 5, 6]))
    np.testing.assert_allclose(found[1, 1, 0], np.mean([0, 1, 2, 5, 6, 10, 11, 12]))
