"""Channels are mixed as numpy would mix them."""

import numpy as np
import pytest

from shapemorph.kernels.luma import mix_channels


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
def test_grey_is_the_scaled_weighted_sum(channels, kind):
    random = np.random.default_rng(channels)
    values = random.integers(0, 250, (7, 11, channels)).astype(kind)
    weights = np.arange(1.0, channels + 1) / np.arange(1.0, channels + 1).sum()
    grey = mix_channels(values, weights, 10.0, 210.0)
    expected = np.clip(((values.astype(float) - 10.0) / 200.0) @ weights, 0.0, 1.0)
    assert grey.dtype == np.float32
    np.testing.assert_allclose(grey, expected, rtol=1e-6)
