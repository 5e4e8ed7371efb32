"""Which points lie within a small distance of each other, by one sweep along a line."""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats, Ints
from shapemorph.kernels.components import join, number_roots

ROUNDED = 1.000001  # positions along the line carry round-off


@njit(cache=True, nogil=True)
def weld_along(points: Floats, place: Floats, order: Ints, tolerance: float) -> tuple[int, Ints]:
    """Group points that chains of short distances join.

    Parameters
    ----------
    points : (N, 3)
    place : (N,)
        Position of each point along a line.
    order : (N,)
        Points sorted by `place`.
    tolerance : float
        Largest distance of two points that belong together.

    Returns
    -------
    count : int
    group : (N,)
        Numbered in the order in which they first appear.
    """
    parent = np.arange(len(points))
    squared, reach = tolerance * tolerance, tolerance * ROUNDED
    for k in range(len(order)):
        here = order[k]
        for m in range(k + 1, len(order)):
            there = order[m]
            if place[there] - place[here] > reach:
                break
            x = points[there, 0] - points[here, 0]
            y = points[there, 1] - points[here, 1]
            z = points[there, 2] - points[here, 2]
            apart = x * x + y * y + z * z
            if apart <= squared:
                join(parent, here, there)
            if apart == 0.0:
                break  # the other one sees whatever follows just as well
    count, group = number_roots(parent)
    return count, group
