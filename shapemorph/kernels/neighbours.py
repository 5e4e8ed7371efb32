"""What the neighbours on a grid say about a point."""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.kernels.inner import inner


@inner()
def _median(values, count) -> float:  # type: ignore[no-untyped-def]
    """Median of the first `count` values, which are sorted in place."""
    for i in range(1, count):
        value, j = values[i], i
        while j > 0 and values[j - 1] > value:
            values[j] = values[j - 1]
            j -= 1
        values[j] = value
    half = count // 2
    return float(values[half] if count % 2 else 0.5 * (values[half - 1] + values[half]))


@njit(cache=True, nogil=True)
def predict_from_neighbours(
    position: Floats,
    gradient: Floats,
    usable: Bools,
    queries: Ints,
    spacing: float,
    reach: int,
    predicted: Floats,
    slope: Floats,
    spread: Floats,
    count: Ints,
) -> None:
    """Predict where points went from the usable points around them, each without itself.

    Every neighbour continues its own affine map to the point; the medians count.

    Parameters
    ----------
    position : (R, C, 2)
        Matched positions.
    gradient : (R, C, 2, 2)
        d position[i] / d grid position[j].
    usable : (R, C) bool
        Points that may speak.
    queries : (Q, 2)
        Row and column of the points to predict.
    spacing : float
        Of the grid, in units of its positions.
    reach : int
        Neighbours up to so many rows and columns away speak.
    predicted : (Q, 2)
        Filled; NaN with fewer than three neighbours; so are the next two.
    slope : (Q, 2, 2) or (0, 2, 2)
        Filled with the predicted gradient, unless it is empty.
    spread : (Q,)
        Filled with the median distance of the neighbours' predictions from the common one.
    count : (Q,) int64
        Filled with the number of neighbours that spoke.
    """
    number, medians = queries.shape[0], (6 if slope.shape[0] > 0 else 2)
    rows, cols = usable.shape
    most = (2 * reach + 1) ** 2
    said, work = np.empty((6, most)), np.empty(most)
    for q in range(number):
        spread[q] = np.nan
        for k in range(2):
            predicted[q, k] = np.nan
        for k in range(2, medians):
            slope[q, (k - 2) // 2, (k - 2) % 2] = np.nan
        row, col = queries[q, 0], queries[q, 1]
        used = 0
        for r in range(max(row - reach, 0), min(row + reach + 1, rows)):
            for c in range(max(col - reach, 0), min(col + reach + 1, cols)):
                if not usable[r, c] or (r == row and c == col):
                    continue
                dx, dy = (col - c) * spacing, (row - r) * spacing
                for k in range(2):
                    along_x, along_y = gradient[r, c, k, 0], gradient[r, c, k, 1]
                    said[k, used] = position[r, c, k] + along_x * dx + along_y * dy
                    said[2 + 2 * k, used] = along_x
                    said[3 + 2 * k, used] = along_y
                used += 1
        count[q] = used
        if used < 3:
            continue
        for k in range(medians):
            for n in range(used):
                work[n] = said[k, n]
            middle = _median(work, used)
            if k < 2:
                predicted[q, k] = middle
            else:
                slope[q, (k - 2) // 2, (k - 2) % 2] = middle
        for n in range(used):
            work[n] = np.hypot(said[0, n] - predicted[q, 0], said[1, n] - predicted[q, 1])
        spread[q] = _median(work, used)
