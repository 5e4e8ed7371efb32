"""Correlation of a whole grid: match, check, and try again from the neighbours."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Codes, Floats, Ints
from shapemorph.core.status import PointStatus
from shapemorph.methods.correlation_checks import find_outliers, neighbour_guesses
from shapemorph.methods.spline_pictures import DeformedPicture, ReferencePicture
from shapemorph.methods.subset_dic import (
    SubsetMatches,
    SubsetSettings,
    affine_starts,
    identity_starts,
    judge_zncc,
    match_points,
)

RESCUES = 8  # rounds in which lost points start from their neighbours
HOPELESS = (PointStatus.OUTSIDE_MASK, PointStatus.LOW_CONTRAST)


@dataclass(frozen=True, slots=True, eq=False)
class GridMatches:
    """What became of the points of a grid, in one morphed picture.

    Attributes
    ----------
    position : (R, C, 2) float64
        Matched positions, px of the morphed picture; meaningless where not OK.
    gradient : (R, C, 2, 2) float64
        d position[i] / d reference[j].
    warps : (R, C, 12) float64
        Whole subset warps.
    zncc : (R, C) float64
    iterations : (R, C) int64
    status : (R, C) uint8
    seconds : float
        In the kernel.
    """

    position: Floats
    gradient: Floats
    warps: Floats
    zncc: Floats
    iterations: Ints
    status: Codes
    seconds: float

    @property
    def ok(self) -> Bools:
        """(R, C) points with a value."""
        return np.asarray(self.status == PointStatus.OK)


def correlate_grid(
    reference: ReferencePicture,
    deformed: DeformedPicture,
    points: Ints,
    inside: Bools,
    *,
    spacing: int,
    settings: SubsetSettings,
    min_zncc: float,
    outlier_floor: float,
) -> GridMatches:
    """Match all points of a grid that are inside.

    First all start from no motion. Points that are lost, or contradict their neighbours,
    start again from what their neighbours say, as long as that brings some back.

    Parameters
    ----------
    reference, deformed : ReferencePicture, DeformedPicture
    points : (R, C, 2)
        Grid, px.
    inside : (R, C) bool
    spacing : int
        Of the grid, px.
    settings : SubsetSettings
    min_zncc : float
        Least zero-mean normalised cross-correlation of a match.
    outlier_floor : float
        Deviation from the neighbours that is always allowed, px.
    """
    grid = _empty(points, inside)
    chosen = np.argwhere(inside)
    at = points[inside]
    first = match_points(reference, deformed, at, identity_starts(len(at)), settings=settings)
    grid = _judged(
        _merged(grid, first, chosen), spacing=spacing, min_zncc=min_zncc, floor=outlier_floor
    )
    for _ in range(RESCUES):
        lost = np.argwhere(~grid.ok & ~np.isin(grid.status, HOPELESS))
        start, slope, known = neighbour_guesses(
            grid.position, grid.gradient, grid.ok, lost, spacing=spacing
        )
        lost, start, slope = lost[known], start[known], slope[known]
        if len(lost) == 0:
            break
        at = points[tuple(lost.T)]
        again = match_points(
            reference, deformed, at, affine_starts(at, start, slope), settings=settings
        )
        before = int(grid.ok.sum())
        grid = _judged(
            _merged(grid, again, lost), spacing=spacing, min_zncc=min_zncc, floor=outlier_floor
        )
        if int(grid.ok.sum()) <= before:
            break
    return grid


def _empty(points: Ints, inside: Bools) -> GridMatches:
    shape = inside.shape
    status = np.where(inside, PointStatus.NOT_SEEDED, PointStatus.OUTSIDE_MASK).astype(np.uint8)
    return GridMatches(
        position=points.astype(np.float64),
        gradient=np.broadcast_to(np.eye(2), (*shape, 2, 2)).copy(),
        warps=identity_starts(inside.size).reshape(*shape, 12),
        zncc=np.full(shape, np.nan),
        iterations=np.zeros(shape, dtype=np.int64),
        status=status,
        seconds=0.0,
    )


def _merged(grid: GridMatches, matches: SubsetMatches, chosen: Ints) -> GridMatches:
    """Put matches in their places of the grid; iterations add up."""
    place = tuple(chosen.T)
    position, gradient = grid.position.copy(), grid.gradient.copy()
    warps, zncc = grid.warps.copy(), grid.zncc.copy()
    iterations, status = grid.iterations.copy(), grid.status.copy()
    position[place], gradient[place] = matches.position, matches.gradient
    warps[place], zncc[place] = matches.warps, matches.zncc
    status[place] = matches.status
    iterations[place] += matches.iterations
    seconds = grid.seconds + matches.seconds
    return GridMatches(position, gradient, warps, zncc, iterations, status, seconds)


def _judged(grid: GridMatches, *, spacing: int, min_zncc: float, floor: float) -> GridMatches:
    """Check what converged against the ZNCC limit and its neighbours."""
    status = np.where(grid.status == PointStatus.OUTLIER, np.uint8(PointStatus.OK), grid.status)
    status = judge_zncc(status, grid.zncc, min_zncc=min_zncc)
    outlier = find_outliers(grid.position, grid.gradient, status, spacing=spacing, floor=floor)
    status = np.where(outlier, np.uint8(PointStatus.OUTLIER), status)
    return GridMatches(
        grid.position, grid.gradient, grid.warps, grid.zncc, grid.iterations, status, grid.seconds
    )
