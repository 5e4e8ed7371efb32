"""Passes over sparse symmetric matrices in rows (CSR, columns ascending).

Vectors are real, or complex for two real right-hand sides at once: the matrix is real.
"""

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shapemorph.core.arrays import Ints

Indices = NDArray[np.int32]
Vector = NDArray[Any]


@njit(cache=True, nogil=True)
def multiply(starts: Indices, columns: Indices, values: Vector, x: Vector, out: Vector) -> None:
    """Write A x.

    Parameters
    ----------
    starts, columns, values
        A in rows: (N + 1,), (Z,), (Z,).
    x : (M,)
    out : (N,)
    """
    for i in range(len(starts) - 1):
        total = out.dtype.type(0)
        for k in range(starts[i], starts[i + 1]):
            total += values[k] * x[columns[k]]
        out[i] = total


@njit(cache=True, nogil=True)
def add_product(starts: Indices, columns: Indices, values: Vector, x: Vector, out: Vector) -> None:
    """Add A x to what is there; sizes as in :func:`multiply`."""
    for i in range(len(starts) - 1):
        total = out[i]
        for k in range(starts[i], starts[i + 1]):
            total += values[k] * x[columns[k]]
        out[i] = total


@njit(cache=True, nogil=True)
def sweep_down(
    starts: Indices, columns: Indices, values: Vector, right: Vector, x: Vector, rest: Vector
) -> None:
    """Write x after one Gauss-Seidel sweep down from zero, and what it leaves of the right side.

    The sweep solves with the lower triangle, so what is left is minus the upper one times x.

    Parameters
    ----------
    starts, columns, values
        A in rows.
    right, x, rest : (N,)
    """
    count = len(starts) - 1
    for i in range(count):
        total = right[i]
        k = starts[i]
        while columns[k] < i:
            total -= values[k] * x[columns[k]]
            k += 1
        x[i] = total / values[k]
    for i in range(count):
        total = right.dtype.type(0)
        k = starts[i + 1] - 1
        while columns[k] > i:
            total -= values[k] * x[columns[k]]
            k -= 1
        rest[i] = total


@njit(cache=True, nogil=True)
def sweep_up(
    starts: Indices, columns: Indices, values: Vector, diagonal: Vector, right: Vector, x: Vector
) -> None:
    """Improve x in place by one Gauss-Seidel sweep upwards.

    Parameters
    ----------
    starts, columns, values
        A in rows.
    diagonal, right, x : (N,)
    """
    for i in range(len(starts) - 2, -1, -1):
        total = right[i]
        for k in range(starts[i], starts[i + 1]):
            total -= values[k] * x[columns[k]]
        x[i] += total / diagonal[i]


@njit(cache=True, nogil=True)
def dot(one: Vector, other: Vector) -> float:
    """Sum of the products of the real parts and of the imaginary parts, always in one order."""
    total = 0.0
    for i in range(len(one)):
        total += one[i].real * other[i].real + one[i].imag * other[i].imag
    return total


@njit(cache=True, nogil=True)
def aggregate(starts: Indices, columns: Indices) -> tuple[int, Ints]:
    """Gather the nodes of a graph into groups of a node and its neighbours.

    Parameters
    ----------
    starts, columns
        The graph in rows, both ways.

    Returns
    -------
    count : int
    group : (N,)

    References
    ----------
    P. Vanek, J. Mandel, M. Brezina, Algebraic multigrid by smoothed aggregation, Computing 56
    (1996), doi 10.1007/BF02238511.
    """
    nodes = len(starts) - 1
    core = np.full(nodes, -1, np.int64)
    count = 0
    for i in range(nodes):
        free = core[i] < 0
        for k in range(starts[i], starts[i + 1]):
            free = free and core[columns[k]] < 0
        if free:
            core[i] = count
            for k in range(starts[i], starts[i + 1]):
                core[columns[k]] = count
            count += 1
    group = core.copy()
    for i in range(nodes):
        for k in range(starts[i], starts[i + 1]):
            if group[i] < 0:
                group[i] = core[columns[k]]
        if group[i] < 0:
            group[i] = count
            count += 1
    return count, group
