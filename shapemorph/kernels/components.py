"""Connected components of graphs that are lists of pairs."""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Ints
from shapemorph.kernels.inner import inner


@njit(cache=True, nogil=True, inline="always")
def find_root(parent: Ints, node: int) -> int:
    """First node of the tree that a node hangs in; shortens the way there."""
    while parent[node] != node:
        parent[node] = parent[parent[node]]
        node = parent[node]
    return node


@njit(cache=True, nogil=True, inline="always")
def join(parent: Ints, one: int, other: int) -> None:
    """Hang two trees together; the lower root stays."""
    one, other = find_root(parent, one), find_root(parent, other)
    if one < other:
        parent[other] = one
    elif other < one:
        parent[one] = other


@inner(nogil=True)
def number_roots(parent: Ints) -> tuple[int, Ints]:
    """Give the trees of a forest numbers in the order in which they first appear.

    Parameters
    ----------
    parent : (N,)
        No parent follows its child, see :func:`join`.

    Returns
    -------
    count : int
    label : (N,)
    """
    label = np.empty(len(parent), np.int64)
    count = 0
    for node in range(len(parent)):
        if parent[node] == node:
            label[node] = count
            count += 1
        else:
            label[node] = label[parent[node]]
    return count, label


@njit(cache=True, nogil=True)
def connect(one: Ints, other: Ints, count: int) -> tuple[int, Ints]:
    """Label the connected components of a graph.

    Parameters
    ----------
    one, other : (K,)
        Nodes that are linked.
    count : int
        Nodes.

    Returns
    -------
    number : int
        Of components.
    label : (N,)
        Component of each node, numbered in the order in which they first appear.
    """
    parent = np.arange(count)
    for k in range(len(one)):
        join(parent, one[k], other[k])
    number, label = number_roots(parent)
    return number, label
