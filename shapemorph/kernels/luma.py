"""Grey from the channels of a picture."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shapemorph.core.arrays import Floats, Greys


@njit(cache=True, nogil=True)
def mix_channels(values: NDArray[np.generic], weights: Floats, floor: float, full: float) -> Greys:
    """Add up the weighted channels of a picture and scale them.

    Parameters
    ----------
    values : (H, W, C)
        Any plain numbers.
    weights : (C,)
        Their sum is one.
    floor, full : float
        Values that become 0 and 1; what lies beyond is clipped.

    Returns
    -------
    (H, W) float32
    """
    height, width, channels = values.shape
    grey = np.empty((height, width), np.float32)
    for row in range(height):
        for col in range(width):
            total = 0.0
            for c in range(channels):
                total += weights[c] * (np.float64(values[row, col, c]) - floor)
            grey[row, col] = min(max(total / (full - floor), 0.0), 1.0)
    return grey
