"""Averages over windows of a grid with gaps."""

import numpy as np
from scipy.ndimage import uniform_filter

from shapemorph.core.arrays import Floats


def average_over_window(values: Floats, *, window: int) -> Floats:
    """Average what is known in a square window around each grid point.

    Parameters
    ----------
    values : (R, C, K)
        NaN where unknown.
    window : int
        Points across.

    Returns
    -------
    (R, C, K)
        NaN where the point itself is unknown.
    """
    known = np.isfinite(values)
    size = (window, window, 1)
    total = uniform_filter(np.where(known, values, 0.0), size, mode="constant")
    share = uniform_filter(known.astype(float), size, mode="constant")
    return np.where(known, total / np.where(known, share, 1.0), np.nan)
