"""Which pairs agree with their neighbours."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.kernels.local_fit import fit_locally

ROUNDS = 3  # outliers that leave uncover others
DIRECTIONS = 8  # half planes that a point beside a kink may agree with


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
    source: Floats,
    target: Floats,
    *,
    neighbours: int,
    tolerance: float,
    cap: float,
    base: Floats | None = None,
) -> Bools:
    """Tell which pairs their neighbours predict, each without itself.

    A robust quadratic surface through the neighbours predicts each pair; a pair that it
    misses may still agree with a plane through the nearest, or with the neighbours on one
    side, as beside a kink of the map. Repeated, since outliers that leave uncover others.

    Parameters
    ----------
    source, target : (N, 2)
        Pairs of points, px.
    neighbours : int
    tolerance : float
        Misfit that is always allowed, px of the target.
    cap : float
        Misfit that is never allowed; between the two, three times the neighbours' own.
    base : (2, 2) or None
        Added to the gradient before its determinant is checked (the identity, where
        `target` is a displacement).

    Returns
    -------
    (N,) bool
    """
    keep = np.arange(len(source))
    for _ in range(ROUNDS):
        if len(keep) < neighbours // 2:
            break
        good = _one_round(
            source[keep],
            target[keep],
            neighbours,
            (tolerance, cap),
            np.zeros((2, 2)) if base is None else base,
        )
        keep = keep[good]
        if good.all():
            break
    result = np.zeros(len(source), bool)
    result[keep] = True
    return result


def _one_round(
    source: Floats, target: Floats, neighbours: int, limits: tuple[float, float], base: Floats
) -> Bools:
    near = _neighbours(source, source, min(2 * neighbours, len(source) - 1) + 1)[:, 1:]
    everything = np.arange(len(source))
    good = np.zeros(len(source), bool)
    attempts = [(6, neighbours, np.zeros(2)), (3, neighbours // 2, np.zeros(2))]
    angles = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    attempts += [(3, neighbours // 2, np.array([np.cos(a), np.sin(a)])) for a in angles]
    for terms, count, side in attempts:
        left = everything[~good]
        good[left] = _agrees(source, target, near[left], left, (terms, count, side), limits, base)
    return good


def _agrees(
    source: Floats,
    target: Floats,
    near: Ints,
    asked: Ints,
    attempt: tuple[int, int, Floats],
    limits: tuple[float, float],
    base: Floats,
) -> Bools:
    terms, count, side = attempt
    sides = np.tile(side, (len(asked), 1))
    predicted, gradient, spread = fit_locally(
        source, target, near, source[asked], sides, count, terms, 0.1 * limits[0]
    )
    misfit = np.linalg.norm(predicted - target[asked], axis=1)
    sound = _determinant(gradient + base) > 0.02
    agrees: Bools = (misfit < np.clip(3.0 * spread, *limits)) & sound
    return agrees


def _determinant(matrices: Floats) -> Floats:
    """Determinants (N,) of (N, 2, 2); NaN stays NaN, without a warning."""
    first, second = matrices[:, 0], matrices[:, 1]
    determinants: Floats = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return determinants


def _neighbours(points: Floats, queries: Floats, count: int) -> Ints:
    from scipy.spatial import cKDTree

    _distance, index = cKDTree(points).query(queries, count)
    return np.ascontiguousarray(np.asarray(index, np.int64).reshape(len(queries), -1))
