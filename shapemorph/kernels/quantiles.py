"""The value below which a share of a weight lies, without sorting everything."""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats

BINS = 4096
FEW = 4096  # values that are sorted at once
MOST_PASSES = 12  # each divides the range by the number of bins


@njit(cache=True, nogil=True)
def _sorted_quantile(values: Floats, weights: Floats, wanted: float) -> float:
    order = np.argsort(values, kind="mergesort")
    total = 0.0
    for k in order:
        total += weights[k]
        if total >= wanted:
            return float(values[k])
    return float(values[order[-1]])


@njit(cache=True, nogil=True)
def select_by_weight(values: Floats, weights: Floats, share: float) -> float:
    """Find the smallest value that together with all below it has a share of the weight.

    Parameters
    ----------
    values : (N,)
    weights : (N,)
        Values that are not finite, or of no weight, do not count.
    share : float
        0 to 1.

    Returns
    -------
    float
        NaN where nothing counts.
    """
    some, heavy = np.empty(len(values)), np.empty(len(values))
    count = 0
    for k in range(len(values)):
        if np.isfinite(values[k]) and weights[k] > 0.0:
            some[count], heavy[count] = values[k], weights[k]
            count += 1
    some, heavy = some[:count], heavy[:count]
    if count == 0:
        return np.nan
    wanted = share * heavy.sum()
    for _ in range(MOST_PASSES):
        low, high = some.min(), some.max()
        if len(some) <= FEW or not low < high:
            break
        width = (high - low) / BINS
        if not (width > 0.0 and np.isfinite(width)):
            break
        bins = np.zeros(BINS)
        for k in range(len(some)):
            bins[min(int((some[k] - low) / width), BINS - 1)] += heavy[k]
        before, chosen = 0.0, 0
        while chosen < BINS - 1 and before + bins[chosen] < wanted:
            before += bins[chosen]
            chosen += 1
        while bins[chosen] == 0.0:
            chosen -= 1
        count = 0
        for k in range(len(some)):
            if min(int((some[k] - low) / width), BINS - 1) == chosen:
                some[count], heavy[count] = some[k], heavy[k]
                count += 1
        some, heavy, wanted = some[:count], heavy[:count], wanted - before
    return float(_sorted_quantile(some, heavy, wanted))
