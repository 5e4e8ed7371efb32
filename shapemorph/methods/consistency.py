"""Which pairs agree with their neighbours."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.kernels.local_fit import fit_locally

ROUNDS = 3  # outliers that leave uncover others
DIRECTIONS = 8  # half planes that a point beside a kink may agree with
LEAST_AREA = 0.02  # of the local map: less is folded or crushed


def frame_support(
    source: Floats,
    target: Floats,
    frames: Floats,
    *,
    neighbours: int,
    relative: float,
    absolute: float,
) -> Floats:
    """Share of the neighbours with which each pair agrees about the local map.

    Two pairs agree if the local map that either brings along predicts the offset between
    their targets.

    Parameters
    ----------
    source, target : (N, 2)
        Pairs of points, px.
    frames : (N, 2, 2)
        Local map d target / d source that each pair claims.
    neighbours : int
    relative, absolute : float
        Largest error of a predicted offset: share of its length, plus px.

    Returns
    -------
    (N,)
        Between 0 and 1; zero where there are fewer than 4 pairs in all.
    """
    count = min(neighbours, len(source) - 1)
    if count < 3:
        return np.zeros(len(source))
    near = _neighbours(source, source, count + 1)[:, 1:]
    step = source[near] - source[:, None]
    offset = target[near] - target[:, None]
    own = np.einsum("nij,nkj->nki", frames, step)
    theirs = np.einsum("nkij,nkj->nki", frames[near], step)
    longest = np.maximum(np.linalg.norm(own, axis=2), np.linalg.norm(theirs, axis=2))
    limit = relative * longest + absolute
    agrees = np.linalg.norm(own - offset, axis=2) < limit
    agrees &= np.linalg.norm(theirs - offset, axis=2) < limit
    support: Floats = agrees.mean(axis=1)
    return support


def consistent_pairs(
    source: Floats, target: Floats, *, neighbours: int, tolerance: float, cap: float
) -> Bools:
    """Tell which pairs their neighbours predict, each without itself.

    A robust quadratic surface through the neighbours predicts each pair; a pair that it
    misses may still agree with a plane through the nearest, or with the neighbours on one
    side, as beside a kink of the map. Repeated, since outliers that leave uncover others.
    A local map that turns the picture over is never agreed with.

    Parameters
    ----------
    source, target : (N, 2)
        Pairs of points, px.
    neighbours : int
    tolerance : float
        Misfit that is always allowed, px of the target.
    cap : float
        Misfit that is never allowed; between the two, three times the neighbours' own.

    Returns
    -------
    (N,) bool
    """
    keep = np.arange(len(source))
    doubted = np.ones(len(source), bool)
    for _ in range(ROUNDS):
        if len(keep) <= neighbours // 2:
            return np.zeros(len(source), bool)
        count = min(2 * neighbours, len(keep) - 1) + 1
        near = _neighbours(source[keep], source[keep], count)[:, 1:]
        circle = _Circle(source[keep], target[keep], near, tolerance, cap)
        good = _agreeing(circle, np.flatnonzero(doubted[keep]), neighbours)
        if good.all():
            break
        doubted[keep] = ~good[near[:, :neighbours]].all(axis=1)
        keep = keep[good]
    result = np.zeros(len(source), bool)
    result[keep] = True
    return result


@dataclass(frozen=True, slots=True, eq=False)
class _Circle:
    """Pairs with their neighbours, nearest first, and what counts as agreement."""

    source: Floats
    target: Floats
    near: Ints
    tolerance: float
    cap: float

    def agrees(self, asked: Ints, terms: int, count: int, side: Floats) -> Bools:
        """Whether a polynomial through (up to `count`) neighbours on a side predicts a pair."""
        predicted, gradient, spread = fit_locally(
            self.source,
            self.target,
            self.near[asked],
            self.source[asked],
            np.tile(side, (len(asked), 1)),
            count,
            terms,
            0.1 * self.tolerance,
        )
        misfit = np.linalg.norm(predicted - self.target[asked], axis=1)
        limit = np.clip(3.0 * spread, self.tolerance, self.cap)
        agrees: Bools = (misfit < limit) & (_determinant(gradient) > LEAST_AREA)
        return agrees


def _agreeing(circle: _Circle, doubted: Ints, neighbours: int) -> Bools:
    """Which pairs agree with their neighbours in one way or another; only doubted are asked."""
    angles = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    sides = [np.zeros(2)] + [np.array([np.cos(angle), np.sin(angle)]) for angle in angles]
    attempts = [(6, neighbours, sides[0])] + [(3, neighbours // 2, side) for side in sides]
    good = np.ones(len(circle.source), bool)
    for terms, count, side in attempts:
        agreed = circle.agrees(doubted, terms, count, side)
        good[doubted] = agreed
        doubted = doubted[~agreed]
    return good


def _determinant(matrices: Floats) -> Floats:
    """Compute (N,) determinants of (N, 2, 2); NaN stays NaN, without a warning."""
    first, second = matrices[:, 0], matrices[:, 1]
    determinants: Floats = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return determinants


def _neighbours(points: Floats, queries: Floats, count: int) -> Ints:
    from scipy.spatial import cKDTree

    _distance, index = cKDTree(points).query(queries, count)
    return np.ascontiguousarray(np.asarray(index, np.int64).reshape(len(queries), -1))
