"""Rows and columns among dots: a walk from neighbour to neighbour."""

import heapq
from typing import TypeAlias

import numpy as np
from scipy.spatial import cKDTree

from shapemorph.core.arrays import Floats, Ints
from shapemorph.methods.cameras.dots import Dots

_NEAR = 0.3  # of a step: how far a neighbour may lie from where it is expected
_SIMILAR = 3.0  # times the area of a dot that its neighbour may have
_SEEDS = 25
_CLEAR = 0.85  # of the dots, times the sine of the angle of the steps: no better walk is sought
Place: TypeAlias = tuple[int, int]


def index_dots(dots: Dots) -> list[tuple[Ints, Ints]]:
    """Walk from dot to dot along two directions, and count the steps.

    Walks begin at dots in the middle and at the largest ones, in turn, until one reaches most
    dots: what looks like dots beside a target may make lattices, too.

    Parameters
    ----------
    dots : Dots

    Returns
    -------
    list of (numbers, steps)
        (M,) int64 dots of a lattice and (M, 2) int64 their place in it, from wherever the walk
        began; the one of most dots first.
    """
    if len(dots.centres) < 4:
        return []
    tree = cKDTree(dots.centres)
    found: dict[tuple[tuple[Place, int], ...], float] = {}
    for seed in _seeds(dots):
        basis = _basis_at(tree, dots.centres, seed)
        if basis is not None:
            walked = _Walk(dots, tree).from_(seed, basis)
            worth = len(walked) * _sine(*basis)  # less for steps that lead across a diagonal
            found[_moved_to_corner(walked)] = worth
            if worth > _CLEAR * len(dots.centres):
                break
    walks = sorted(found, key=lambda walk: -found[walk])
    return [
        (np.array([dot for _, dot in walk], np.int64), np.array([at for at, _ in walk], np.int64))
        for walk in walks
    ]


def _seeds(dots: Dots) -> list[int]:
    """Dots to begin at: the one nearest the middle, the largest, the second nearest, ..."""
    middle = np.median(dots.centres, axis=0)
    near = np.argsort(np.linalg.norm(dots.centres - middle, axis=1), kind="stable")
    large = np.argsort(-dots.areas, kind="stable")
    both = np.stack([near, large], axis=1).ravel().tolist()
    return list(dict.fromkeys(both))[:_SEEDS]


def _moved_to_corner(walked: dict[Place, int]) -> tuple[tuple[Place, int], ...]:
    """Count the steps of a walk from its lowest row and column: from any seed the same."""
    low = np.min(list(walked), axis=0).tolist()
    return tuple(
        sorted(((row - low[0], column - low[1]), dot) for (row, column), dot in walked.items())
    )


def _basis_at(tree: "cKDTree", centres: Floats, seed: int) -> Floats | None:
    """Two steps from a dot to neighbours that have one opposite."""
    numbers = np.atleast_1d(tree.query(centres[seed], k=min(9, len(centres)))[1])[1:]
    steps = centres[numbers] - centres[seed]
    opposite = np.linalg.norm(steps[:, None] + steps[None, :], axis=-1).min(axis=1)
    lengths = np.linalg.norm(steps, axis=1)
    sound = np.flatnonzero(opposite < _NEAR * lengths)
    for number in sound[1:]:
        first, other = steps[sound[0]], steps[number]
        if _sine(first, other) > 0.5:
            return np.array([first, other])
    return None


def _sine(first: Floats, other: Floats) -> float:
    """Sine of the angle between two steps."""
    area = abs(first[0] * other[1] - first[1] * other[0])
    return float(area / (np.linalg.norm(first) * np.linalg.norm(other)))


class _Walk:
    """A walk over dots, the step that is best foreseen first."""

    def __init__(self, dots: Dots, tree: "cKDTree") -> None:
        self._centres, self._areas, self._tree = dots.centres, dots.areas, tree
        self._at: dict[Place, int] = {}
        self._taken: set[int] = set()
        self._waiting: list[tuple[float, Place, int, int, int]] = []

    def from_(self, seed: int, basis: Floats) -> dict[Place, int]:
        """Return the dot at each place that was reached."""
        self._basis = {(0, 0): basis}
        self._enter((0, 0), seed)
        while self._waiting:
            _, goal, number, origin, axis = heapq.heappop(self._waiting)
            if goal in self._at or number in self._taken:
                continue
            before = self._place_of[origin]
            steps = self._basis[before].copy()
            sign = goal[axis] - before[axis]
            steps[axis] = sign * (self._centres[number] - self._centres[origin])
            self._basis[goal] = steps
            self._enter(goal, number)
        return self._at

    def _enter(self, place: Place, number: int) -> None:
        if not self._at:
            self._place_of: dict[int, Place] = {}
        self._at[place] = number
        self._place_of[number] = place
        self._taken.add(number)
        for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1)):
            goal = stepped(place, axis, sign)
            if goal not in self._at:
                self._foresee(place, goal, axis, sign)

    def _foresee(self, place: Place, goal: Place, axis: int, sign: int) -> None:
        here = self._at[place]
        step = sign * self._basis[place][axis]
        back, further = (self._at.get(stepped(place, axis, -k * sign)) for k in (1, 2))
        if back is not None:
            step = self._centres[here] - self._centres[back]
            if further is not None:
                step = 2 * step - (self._centres[back] - self._centres[further])
        gap, number = self._tree.query(self._centres[here] + step)
        length = float(np.linalg.norm(step))
        ratio = self._areas[number] / self._areas[here]
        if gap < _NEAR * length and 1 / _SIMILAR < ratio < _SIMILAR:
            entry = (float(gap) / length, goal, int(number), here, axis)
            heapq.heappush(self._waiting, entry)


def stepped(place: Place, axis: int, count: int) -> Place:
    """Go some steps along rows (axis 0) or columns (axis 1)."""
    return (place[0] + count, place[1]) if axis == 0 else (place[0], place[1] + count)
