"""A membrane of triangles in equilibrium, found by Newton's method on its energy."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from scipy import sparse
from scipy.sparse import linalg

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.kernels.membrane import add_pressure, membrane_energy

MOST_STEPS, MOST_HALVINGS = 80, 25
LARGEST_MOVE = 2.0  # edges: no node moves farther in one step
SETTLED = 1e-7  # of the force that a strain of one makes in an edge
DAMPING = 1e-7  # of the mean stiffness: a flat membrane has none across its plane

Support: TypeAlias = Callable[[Floats], tuple[float, Floats, Floats]]
"""Nodes (N, 3) -> energy, its gradient (N, 3) and second derivatives (N, 3, 3) at each node."""


@dataclass(frozen=True, slots=True)
class Law:
    """Energy of a unit of volume: factor (I + shift)^power, I = tr C + 1 / det C - 3, MPa."""

    factor: float
    shift: float
    power: float


def neo_hookean(shear_modulus: float) -> Law:
    """Rubber: energy mu I / 2, with the shear modulus mu in MPa."""
    return Law(0.5 * shear_modulus, 0.0, 1.0)


def viscous_step(consistency: float, exponent: float, seconds: float) -> Law:
    """One step of a sheet that flows by sigma = K rate^m, from the state that begins the step.

    The equivalent strain of a step is sqrt(I / 3); the energy K t / (m + 1) (strain / t)^(m + 1)
    has the stress as its derivative.
    """
    power = 0.5 * (exponent + 1.0)
    factor = consistency * seconds / (exponent + 1.0) / (3.0 * seconds**2) ** power
    return Law(factor, 1e-7, power)


class Membrane:
    """Triangles of a sheet with some nodes held.

    Parameters
    ----------
    points : (N, 3)
        Nodes without stress, mm.
    faces : (F, 3)
    thickness : (F,)
        mm.
    held : (N,) bool
        Nodes that do not move.
    """

    def __init__(self, points: Floats, faces: Ints, thickness: Floats, held: Bools) -> None:
        self.points, self.faces, self.thickness = points, faces, thickness
        self.free = np.repeat(~held, 3)
        origin, along = points[faces[:, 0]], points[faces[:, 1:]]
        first, second = (along - origin[:, None]).swapaxes(0, 1)
        length = np.linalg.norm(first, axis=1)
        normal = np.cross(first, second)
        area = np.linalg.norm(normal, axis=1)
        across = np.cross(normal / area[:, None], first / length[:, None])
        corners = np.zeros((len(faces), 2, 2))
        corners[:, 0, 0] = length
        corners[:, 1, 0] = (second * first).sum(axis=1) / length
        corners[:, 1, 1] = (second * across).sum(axis=1)
        others = np.linalg.inv(corners).swapaxes(1, 2)  # gradients of the second and third
        self.slopes = np.concatenate([-others.sum(axis=1, keepdims=True), others], axis=1)
        self.area = 0.5 * area
        self.node_area = np.bincount(
            faces.ravel(), np.repeat(self.area / 3, 3), minlength=len(points)
        )
        self.edge = float(np.sqrt(self.area.mean()))
        self._pattern = _Pattern(faces, self.free)

    def equilibrium(
        self,
        start: Floats,
        law: Law,
        *,
        pressure: float = 0.0,
        support: Support | None = None,
    ) -> Floats:
        """Find the nodes (N, 3) at which no force is left.

        Parameters
        ----------
        start : (N, 3)
            Where to begin, mm.
        law : Law
        pressure : float
            On the side that the faces turn away from, MPa.
        support : callable or None
            What the sheet leans against.

        Raises
        ------
        StageError
            If the steps do not settle.
        """
        problem = _Problem(self, law, pressure, support)
        x, small = start.copy(), SETTLED * law.factor * self.thickness.mean() * self.edge
        energy, forces, matrix = problem.at(x)
        damping = DAMPING
        for _ in range(MOST_STEPS):
            if np.abs(forces[self.free]).max() < small:
                return x
            move = self._direction(matrix, forces, damping)
            taken = self._taken(problem, x, energy, move, float(forces @ move))
            if taken is None:
                damping = max(10.0 * damping, 1e-6)
                if damping > 1e3:
                    break
                continue
            x = x + taken * move.reshape(-1, 3)
            damping = max(0.1 * damping, DAMPING)
            energy, forces, matrix = problem.at(x)
        left = float(np.abs(forces[self.free]).max())
        raise StageError(
            f"the membrane found no equilibrium: a force of {left:.1e} N is left, {small:.1e} N "
            "would do; use smaller steps"
        )

    def stretches(self, x: Floats) -> Floats:
        """Principal stretches (F, 2) of the triangles, the larger one last."""
        part = np.einsum("fai,fab->fib", x[self.faces], self.slopes)
        return np.sqrt(np.linalg.eigvalsh(part.swapaxes(1, 2) @ part))

    def _direction(self, matrix: Any, forces: Floats, damping: float) -> Floats:
        stiff = matrix + damping * matrix.diagonal().mean() * sparse.identity(
            matrix.shape[0], format="csc"
        )
        factor = linalg.splu(
            stiff,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        move = np.zeros(len(self.free))
        move[self.free] = -factor.solve(forces[self.free])
        return move

    def _taken(
        self, problem: "_Problem", x: Floats, energy: float, move: Floats, slope: float
    ) -> float | None:
        """Share of a move that lowers the energy enough; None if it leads uphill."""
        if slope >= 0.0:
            return None
        share = min(1.0, LARGEST_MOVE * self.edge / max(float(np.abs(move).max()), 1e-300))
        for _ in range(MOST_HALVINGS):
            there = problem.energy(x + share * move.reshape(-1, 3))
            if there <= energy + 1e-4 * share * slope + 1e-13 * abs(energy):
                return share
            share *= 0.5
        return None


class _Problem:
    """Energy of a membrane under its loads, with derivatives."""

    def __init__(
        self, membrane: Membrane, law: Law, pressure: float, support: Support | None
    ) -> None:
        self._membrane, self._law = membrane, law
        self._pressure, self._support = pressure, support
        self._blocks = np.zeros((len(membrane.faces), 9, 9))
        self._volumes = membrane.area * membrane.thickness

    def energy(self, x: Floats) -> float:
        return self._sum(x, np.zeros_like(x), with_blocks=False)[0]

    def at(self, x: Floats) -> tuple[float, Floats, Any]:
        """Energy, forces (3 N,) and stiffness of the free unknowns."""
        forces = np.zeros_like(x)
        energy, nodes = self._sum(x, forces, with_blocks=True)
        return energy, forces.ravel(), self._membrane._pattern.matrix(self._blocks, nodes)

    def _sum(self, x: Floats, forces: Floats, *, with_blocks: bool) -> tuple[float, Floats | None]:
        sheet, law, nodes = self._membrane, self._law, None
        energy = membrane_energy(
            x,
            sheet.faces,
            sheet.slopes,
            self._volumes,
            law.factor,
            law.shift,
            law.power,
            forces,
            self._blocks,
            with_blocks,
        )
        if self._pressure:
            energy += add_pressure(
                x, sheet.faces, self._pressure, forces, self._blocks, with_blocks
            )
        if self._support is not None:
            added, gradient, nodes = self._support(x)
            energy += added
            forces += gradient
        return energy, nodes


class _Pattern:
    """Where the entries of the blocks go in the sparse matrix of the free unknowns."""

    def __init__(self, faces: Ints, free: Bools) -> None:
        self._count = int(free.sum())
        number = np.full(len(free), -1)
        number[free] = np.arange(self._count)
        unknown = number[(3 * faces[:, :, None] + np.arange(3)).reshape(len(faces), 9)]
        rows, columns = np.repeat(unknown, 9, axis=1), np.tile(unknown, (1, 9))
        own = number.reshape(-1, 3)
        node_rows, node_columns = np.repeat(own, 3, axis=1), np.tile(own, (1, 3))
        rows = np.concatenate([rows.ravel(), node_rows.ravel()])
        columns = np.concatenate([columns.ravel(), node_columns.ravel()])
        self._kept = (rows >= 0) & (columns >= 0)
        key = columns[self._kept] * self._count + rows[self._kept]
        places, self._place = np.unique(key, return_inverse=True)
        self._rows = (places % self._count).astype(np.int32)
        ends = np.cumsum(np.bincount(places // self._count, minlength=self._count))
        self._starts = np.concatenate([[0], ends]).astype(np.int32)
        self._nodes = len(own)

    def matrix(self, blocks: Floats, nodes: Floats | None) -> Any:
        at_nodes = np.zeros((self._nodes, 3, 3)) if nodes is None else nodes
        values = np.concatenate([blocks.ravel(), at_nodes.ravel()])[self._kept]
        data = np.bincount(self._place, values, minlength=len(self._rows))
        return sparse.csc_matrix((data, self._rows, self._starts), (self._count, self._count))
