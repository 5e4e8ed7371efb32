"""Sort pairs of whole numbers, edges among them, in linear time where few share the first."""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Ints

FEW = 32  # pairs with one first number up to which insertion is the quickest


@njit(cache=True, nogil=True)
def _insert(order: Ints, second: Ints, start: int, end: int) -> None:
    for k in range(start + 1, end):
        item = order[k]
        place = k
        while place > start and second[order[place - 1]] > second[item]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = item


@njit(cache=True, nogil=True)
def order_pairs(first: Ints, second: Ints, count: int) -> Ints:
    """Sort pairs by their first number, then the second, then their place.

    Parameters
    ----------
    first : (K,)
        From 0 to `count` - 1.
    second : (K,)
    count : int

    Returns
    -------
    (K,)
        Rows in order.
    """
    ends = np.zeros(count + 1, np.int64)
    for k in range(len(first)):
        ends[first[k] + 1] += 1
    ends = np.cumsum(ends)
    order = np.empty(len(first), np.int64)
    place = ends[:-1].copy()
    for k in range(len(first)):
        order[place[first[k]]] = k
        place[first[k]] += 1
    for value in range(count):
        start, end = ends[value], ends[value + 1]
        if end - start <= FEW:
            _insert(order, second, start, end)
        else:
            some = order[start:end].copy()
            order[start:end] = some[np.argsort(second[some], kind="mergesort")]
    return order


@njit(cache=True, nogil=True)
def order_sides(faces: Ints, count: int) -> tuple[Ints, Ints]:
    """Sort the sides of triangles by their edge.

    Side ``3 f + k`` runs from corner k of face f to the next.

    Parameters
    ----------
    faces : (F, 3)
    count : int
        Vertices.

    Returns
    -------
    order : (3 F,)
        Sides, those of one edge next to each other in their order.
    first : (E,)
        Where in `order` each edge begins.
    """
    low = np.empty(3 * len(faces), np.int64)
    high = np.empty(3 * len(faces), np.int64)
    for f in range(len(faces)):
        for k in range(3):
            start, end = faces[f, k], faces[f, (k + 1) % 3]
            low[3 * f + k], high[3 * f + k] = min(start, end), max(start, end)
    order = order_pairs(low, high, count)
    first = np.empty(len(order), np.int64)
    edges = 0
    for k in range(len(order)):
        if k == 0 or low[order[k]] != low[order[k - 1]] or high[order[k]] != high[order[k - 1]]:
            first[edges] = k
            edges += 1
    return order, first[:edges].copy()
