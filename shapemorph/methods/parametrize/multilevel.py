"""Conjugate gradients with a multilevel preconditioner, for surfaces of many vertices.

The preconditioner works in single precision, the iteration in double.

References
----------
P. Vanek, J. Mandel, M. Brezina, Algebraic multigrid by smoothed aggregation, Computing 56
(1996), doi 10.1007/BF02238511.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from shapemorph.core.arrays import Floats
from shapemorph.kernels import sparse

Vector = NDArray[Any]
Rows = tuple[sparse.Indices, sparse.Indices, Vector]

COARSEST = 20_000  # rows that are factorised
POWER_STEPS = 10  # towards the largest eigenvalue
SAFETY = 1.1  # on that estimate
ACCURACY = 1e-10  # of the error in the energy norm, relative to the start
MOST_ITERATIONS = 150


@dataclass(frozen=True, slots=True, eq=False)
class _Level:
    """Rows of a system and its diagonal, of the way down to a coarser one and of that back up."""

    matrix: Rows
    diagonal: Vector
    restrict: Rows
    prolong: Rows


def multilevel_solver(
    matrix: "csr_array[np.float64]", factorise: Callable[[Any], Callable[[Floats], Floats]]
) -> Callable[[Floats], Floats | None]:
    """Prepare a positive definite system of the kind of a Laplacian.

    Parameters
    ----------
    matrix : (N, N)
        Symmetric, positive definite.
    factorise : callable
        Gives the solver of the coarsest system.

    Returns
    -------
    callable
        Right-hand side (N,) or (N, K) to the solution; None where the iteration stalls.
    """
    matrix.sort_indices()
    levels: list[_Level] = []
    coarse = matrix
    while coarse.shape[0] > COARSEST:
        level, coarse = _coarsen(coarse)
        levels.append(level)
    coarsest, rows = factorise(coarse), _rows(matrix)

    def precondition(right: Vector) -> Vector:
        single = np.complex64 if np.iscomplexobj(right) else np.float32
        return _cycle(levels, coarsest, right.astype(single), 0).astype(right.dtype)

    def solve(right: Floats) -> Floats | None:
        columns = right.reshape(len(right), -1)
        solved = []
        for k in range(0, columns.shape[1], 2):
            found = _conjugate_gradients(rows, precondition, _one_column(columns[:, k : k + 2]))
            if found is None:
                return None
            solved.append(_columns(found))
        return np.concatenate(solved, axis=1).reshape(right.shape)

    return solve


def _one_column(pair: Floats) -> Vector:
    """One real column as it is, two as one complex one."""
    if pair.shape[1] == 1:
        return np.ascontiguousarray(pair[:, 0])
    return pair[:, 0] + 1j * pair[:, 1]


def _columns(vector: Vector) -> Floats:
    if np.iscomplexobj(vector):
        return np.stack([vector.real, vector.imag], axis=1)
    return vector[:, None]


def _rows(matrix: "csr_array[np.float64]", kind: type[np.floating[Any]] = np.float64) -> Rows:
    return (
        matrix.indptr.astype(np.int32),
        matrix.indices.astype(np.int32),
        matrix.data.astype(kind),
    )


def _coarsen(matrix: "csr_array[np.float64]") -> tuple[_Level, "csr_array[np.float64]"]:
    """Gather rows into groups; what is constant on each, smoothed, spans the coarser system."""
    rows, diagonal = _rows(matrix), matrix.diagonal()
    count, group = sparse.aggregate(*rows[:2])
    size = len(group)
    lumped = csr_array((np.ones(size), group, np.arange(size + 1)), shape=(size, count))
    damping = 4.0 / (3.0 * _largest_eigenvalue(rows, diagonal))
    product = matrix @ lumped
    product.data *= np.repeat(damping / diagonal, np.diff(product.indptr))
    prolong = csr_array(lumped - product)
    restrict = csr_array(prolong.T.tocsr())
    coarse = csr_array(restrict @ (matrix @ prolong))
    coarse.sort_indices()
    single = np.float32
    level = _Level(
        _rows(matrix, single),
        diagonal.astype(single),
        _rows(restrict, single),
        _rows(prolong, single),
    )
    return level, coarse


def _largest_eigenvalue(rows: Rows, diagonal: Floats) -> float:
    """Estimate that of D^-1 A from below by power iteration, and add to it."""
    vector = np.cos(2.4 * np.arange(len(diagonal)))  # nothing that a mesh could be symmetric to
    product = np.empty_like(vector)
    value = 1.0
    for _ in range(POWER_STEPS):
        sparse.multiply(*rows, vector, product)
        product /= diagonal
        value = float(np.sqrt(sparse.dot(product, product) / sparse.dot(vector, vector)))
        vector, product = product / value, vector
    return SAFETY * value


def _cycle(
    levels: list[_Level], coarsest: Callable[[Floats], Floats], right: Vector, depth: int
) -> Vector:
    """Solve roughly: smooth, correct by the coarser level, smooth the other way round."""
    if depth == len(levels):
        return _one_column(coarsest(_columns(right).astype(np.float64))).astype(right.dtype)
    level = levels[depth]
    x, rest = np.empty_like(right), np.empty_like(right)
    sparse.sweep_down(*level.matrix, right, x, rest)
    below = np.empty(len(level.restrict[0]) - 1, right.dtype)
    sparse.multiply(*level.restrict, rest, below)
    sparse.add_product(*level.prolong, _cycle(levels, coarsest, below, depth + 1), x)
    sparse.sweep_up(*level.matrix, level.diagonal, right, x)
    return x


def _conjugate_gradients(
    rows: Rows, precondition: Callable[[Vector], Vector], right: Vector
) -> Vector | None:
    """Solve until the error has fallen far enough."""
    x, rest, product = np.zeros_like(right), right.copy(), np.empty_like(right)
    direction = precondition(rest)
    energy = sparse.dot(rest, direction)
    enough = ACCURACY**2 * energy
    for _ in range(MOST_ITERATIONS):
        if 0 <= energy <= enough:
            return x
        sparse.multiply(*rows, direction, product)
        curvature = sparse.dot(direction, product)
        if not (curvature > 0 and energy > 0):
            return None
        length = energy / curvature
        x += length * direction
        rest -= length * product
        better = precondition(rest)
        before, energy = energy, sparse.dot(rest, better)
        direction *= energy / before
        direction += better
    return None
