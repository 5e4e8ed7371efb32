"""Best and second best entries of a matrix of likenesses, in one pass."""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Floats, Greys, Ints


@njit(cache=True, nogil=True, parallel=True)
def two_best(
    likeness: Greys, places: Floats, apart: float, nearest: Ints, best: Greys, second: Greys
) -> None:
    """Find the best entry of every row, and the best one at another place.

    Parameters
    ----------
    likeness : (R, C) float32
    places : (C, 2)
        Where the columns lie.
    apart : float
        Columns nearer to the best one than this are the same place.
    nearest, best, second : (R,)
        Filled in: best column, its likeness, and that of the best column elsewhere (-1
        if there is none). Ties go to the lower column.
    """
    for row in prange(likeness.shape[0]):
        nearest[row], best[row], second[row] = _two_best(likeness[row], places, apart)


@njit(cache=True)
def _two_best(likeness: Greys, places: Floats, apart: float) -> tuple[int, float, float]:
    nearest, best = 0, np.float32(-1.0)
    for column in range(likeness.size):
        if likeness[column] > best:
            nearest, best = column, likeness[column]
    second, limit = np.float32(-1.0), apart * apart
    for column in range(likeness.size):
        if likeness[column] > second:
            dx = places[column, 0] - places[nearest, 0]
            dy = places[column, 1] - places[nearest, 1]
            if dx * dx + dy * dy >= limit:
                second = likeness[column]
    return nearest, float(best), float(second)


@njit(cache=True, nogil=True, parallel=True)
def improve_columns(likeness: Greys, start: int, nearest: Ints, best: Greys, width: int) -> None:
    """Bring up to date, for every column, its best row so far.

    Parameters
    ----------
    likeness : (R, C) float32
    start : int
        Number of the first row.
    nearest, best : (C,)
        Changed in place: best row and its likeness. Ties go to the row that came first.
    width : int
        Columns that one thread takes at a time.
    """
    for part in prange((likeness.shape[1] + width - 1) // width):
        _improve(likeness, start, nearest, best, part * width, width)


@njit(cache=True)
def _improve(
    likeness: Greys, start: int, nearest: Ints, best: Greys, first: int, width: int
) -> None:
    last = min(first + width, likeness.shape[1])
    for row in range(likeness.shape[0]):
        for column in range(first, last):
            if likeness[row, column] > best[column]:
                best[column], nearest[column] = likeness[row, column], start + row
