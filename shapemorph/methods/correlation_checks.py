"""Check converged points against what their neighbours say."""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from shapemorph.core.arrays import Bools, Codes, Floats, Ints
from shapemorph.core.status import PointStatus
from shapemorph.kernels.components import connect
from shapemorph.kernels.neighbours import predict_from_neighbours
from shapemorph.methods.threads import run_blocks

Values = TypeVar("Values", Floats, Ints)

REACH = 2  # neighbours in a window of 5 x 5 points
SPREADS = 5.0  # a point may be so many spreads of its neighbours' predictions off
BLOCK = 1024  # points that a thread takes at once
ROUNDS = 3
MIN_ISLAND = 5  # points; fewer that no neighbour confirms are not believed
FEW_POINTS = 20  # on a smaller grid the largest group is believed, however small


def neighbour_guesses(
    position: Floats, gradient: Floats, usable: Bools, queries: Ints, *, spacing: int
) -> tuple[Floats, Floats, Bools]:
    """Guess where points went from usable neighbours.

    Parameters
    ----------
    position : (R, C, 2)
    gradient : (R, C, 2, 2)
    usable : (R, C) bool
    queries : (Q, 2)
        Row and column of the points to guess.
    spacing : int
        Of the grid, px.

    Returns
    -------
    position : (Q, 2)
    gradient : (Q, 2, 2)
    known : (Q,) bool
        Where there were enough neighbours; NaN elsewhere.

    References
    ----------
    Genovese, Sorgente (2017), Eq. 2, doi:10.1016/j.optlaseng.2017.06.020: first guesses
    from at least three neighbours; here by medians of what each of them predicts.
    """
    slope = np.empty((len(queries), 2, 2))
    found, spread = _predict(position, gradient, usable, queries, slope, spacing=spacing)
    return found, slope, np.isfinite(spread)


@dataclass(frozen=True, slots=True, eq=False)
class FirstLook:
    """What a first look at a grid found: points far from any change need no second one.

    Attributes
    ----------
    position : (R, C, 2)
    gradient : (R, C, 2, 2)
    candidate : (R, C) bool
        Points that were judged, and spoke.
    doubted : (R, C) bool
        Those that contradict their neighbours where all of them speak.
    """

    position: Floats
    gradient: Floats
    candidate: Bools
    doubted: Bools

    def changed(self, position: Floats, gradient: Floats, candidate: Bools) -> Bools:
        """Points (R, C) that are not what they were, or no longer speak, or speak now."""
        moved = (position != self.position).any(axis=-1)
        moved |= (gradient != self.gradient).any(axis=(-1, -2))
        return np.asarray((moved & candidate) | (candidate != self.candidate))


def find_outliers(
    position: Floats,
    gradient: Floats,
    status: Codes,
    *,
    spacing: int,
    floor: float,
    before: FirstLook | None = None,
) -> tuple[Bools, FirstLook]:
    """Find points that contradict their neighbours.

    The neighbours' affine maps, continued to the point, say where it should be. It may be
    off by some spreads of what they say: beside a kink they disagree, so more is allowed
    there than in a smooth field. Found points lose their say and all are judged again.
    Last, groups of a few points that no longer hang together with the rest are dropped.

    Parameters
    ----------
    position : (R, C, 2)
        Matched positions, px.
    gradient : (R, C, 2, 2)
    status : (R, C)
        Only OK points are judged, and speak.
    spacing : int
        Of the grid, px.
    floor : float
        Deviation that is always allowed, px.
    before : FirstLook or None
        At the same grid, with the same `spacing` and `floor`, when some points were otherwise.

    Returns
    -------
    outlier : (R, C) bool
    FirstLook
        For a next time.
    """
    candidate = status == PointStatus.OK
    at = np.nonzero(candidate)
    queries = np.argwhere(candidate)
    outlier = np.zeros_like(candidate)
    doubted, stale = np.zeros(len(queries), dtype=bool), np.ones(len(queries), dtype=bool)
    if before is not None:
        doubted = before.doubted[at]
        stale = _near(before.changed(position, gradient, candidate))[at]
    looks = []
    for _ in range(ROUNDS):
        last = outlier
        deviation, allowed = _deviations(
            position, gradient, candidate & ~last, queries[stale], spacing=spacing, floor=floor
        )
        doubted[stale] = deviation > allowed
        outlier = np.zeros_like(candidate)
        outlier[tuple(queries[doubted].T)] = True
        looks.append(outlier)
        stale = _near(outlier != last)[at]
        if not stale.any():
            break
    status = np.where(outlier, np.uint8(PointStatus.OUTLIER), status)
    islands = _islands(position, gradient, status, spacing=spacing, floor=floor)
    return outlier | islands, FirstLook(position, gradient, candidate, looks[0])


def _near(changed: Bools) -> Bools:
    """Points (R, C) that have one of these within their reach."""
    import cv2

    window = np.ones((2 * REACH + 1, 2 * REACH + 1), np.uint8)
    return np.asarray(cv2.dilate(changed.astype(np.uint8), window) > 0)


def _predict(
    position: Floats, gradient: Floats, usable: Bools, queries: Ints, slope: Floats, *, spacing: int
) -> tuple[Floats, Floats]:
    """Position and spread that the neighbours predict; NaN where too few.

    `slope` (Q, 2, 2) is filled with the gradient that they predict, unless it is empty.
    """
    position, gradient = np.ascontiguousarray(position), np.ascontiguousarray(gradient)
    queries = np.ascontiguousarray(queries)
    number = len(queries)
    found, spread = np.empty((number, 2)), np.empty(number)
    count = np.empty(number, dtype=np.int64)

    def work(first: int, last: int) -> None:
        some = slice(first, last)
        results = found[some], slope[some], spread[some], count[some]
        predict_from_neighbours(
            position, gradient, usable, queries[some], float(spacing), REACH, *results
        )

    run_blocks(work, number, block=BLOCK)
    return found, spread


def _deviations(
    position: Floats, gradient: Floats, usable: Bools, queries: Ints, *, spacing: int, floor: float
) -> tuple[Floats, Floats]:
    """(Q,) distance from what the neighbours say, and the distance that is allowed."""
    no_slope = np.empty((0, 2, 2))
    predicted, spread = _predict(position, gradient, usable, queries, no_slope, spacing=spacing)
    off = position[tuple(queries.T)] - predicted
    return np.hypot(off[:, 0], off[:, 1]), np.maximum(SPREADS * spread, floor)


def _islands(
    position: Floats, gradient: Floats, status: Codes, *, spacing: int, floor: float
) -> Bools:
    """Small groups of points, each joined to neighbours that it agrees with."""
    usable = status == PointStatus.OK
    number = np.full(usable.shape, -1)
    number[usable] = np.arange(np.count_nonzero(usable))
    pairs = [
        _agreeing(position, gradient, number, step, spacing=spacing, floor=floor)
        for step in ((0, 1), (1, 0), (1, 1), (1, -1))
    ]
    first, second = np.concatenate(pairs, axis=1)
    total = int(number.max(initial=-1)) + 1
    if total == 0:
        return np.zeros(usable.shape, dtype=bool)
    _count, label = connect(first, second, total)
    size = np.bincount(label)
    tried = np.count_nonzero(status != PointStatus.OUTSIDE_MASK)
    small = size < (MIN_ISLAND if tried >= FEW_POINTS else min(MIN_ISLAND, size.max()))
    found = np.zeros_like(usable)
    found[usable] = small[label]
    return np.asarray(found)


def _agreeing(
    position: Floats,
    gradient: Floats,
    number: Ints,
    step: tuple[int, int],
    *,
    spacing: int,
    floor: float,
) -> Ints:
    """(2, K) numbers of neighbours, `step` rows and columns apart, that continue each other."""
    here, there = _shifted(number, step)
    at = _shifted(position, step)
    slope = _shifted(gradient, step)
    way = spacing * np.array([step[1], step[0]], dtype=np.float64)
    ahead, behind = (_along(each, way) for each in slope)
    gap = at[1] - at[0] - 0.5 * (ahead + behind)
    bend = 0.5 * _lengths(behind - ahead)
    good = (here >= 0) & (there >= 0)
    good &= _lengths(gap) <= np.maximum(floor, bend)
    return np.stack([here[good], there[good]])


def _along(slope: Floats, way: Floats) -> Floats:
    """Multiply gradients (..., 2, 2) by one step: as :func:`numpy.matmul`, but quick."""
    product: Floats = slope[..., 0] * way[0] + slope[..., 1] * way[1]
    return product


def _lengths(vectors: Floats) -> Floats:
    """Lengths of vectors (..., 2)."""
    return np.asarray(np.hypot(vectors[..., 0], vectors[..., 1]))


def _shifted(values: Values, step: tuple[int, int]) -> tuple[Values, Values]:
    """Values of each point and of the one `step` rows and columns on."""
    rows, cols = step
    high = values[: values.shape[0] - rows]
    low = values[rows:]
    if cols > 0:
        return high[:, :-cols], low[:, cols:]
    if cols < 0:
        return high[:, -cols:], low[:, :cols]
    return high, low
