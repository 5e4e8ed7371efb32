"""Correlation of a whole grid: match, check, and try again from the neighbours."""

from dataclasses import dataclass, replace

import numpy as np

from shapemorph.core.arrays import Bools, Codes, Floats, Ints
from shapemorph.core.status import PointStatus
from shapemorph.methods.correlation_checks import FirstLook, find_outliers, neighbour_guesses
from shapemorph.methods.spline_pictures import DeformedPicture, ReferencePicture
from shapemorph.methods.subset_dic import (
    PointGrid,
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
    look : FirstLook or None
        From when the points were last judged.
    """

    position: Floats
    gradient: Floats
    warps: Floats
    zncc: Floats
    iterations: Ints
    status: Codes
    seconds: float
    look: FirstLook | None = None

    @property
    def ok(self) -> Bools:
        """(R, C) points with a value."""
        return np.asarray(self.status == PointStatus.OK)


@dataclass(frozen=True, slots=True)
class Limits:
    """What a match must keep to be believed.

    Attributes
    ----------
    min_zncc : float
        Least zero-mean normalised cross-correlation.
    outlier_floor : float
        Deviation from the neighbours that is always allowed, px.
    """

    min_zncc: float
    outlier_floor: float


def correlate_grid(
    reference: ReferencePicture,
    deformed: DeformedPicture,
    grid: PointGrid,
    *,
    settings: SubsetSettings,
    limits: Limits,
    starts: Floats | None = None,
) -> GridMatches:
    """Match all points of a grid that are inside.

    First all start from `starts` (N, 12), row by row, or from no motion. Points that are
    lost, or contradict their neighbours, start again from what their neighbours say, as
    long as that brings some back.
    """
    chosen = np.argwhere(grid.inside)
    at = grid.points[grid.inside]
    starts = identity_starts(len(at)) if starts is None else starts
    first = match_points(reference, deformed, at, starts, settings=settings)
    found = judged_matches(merged_matches(empty_matches(grid), first, chosen), grid.spacing, limits)
    return rescued_matches(reference, deformed, grid, found, settings=settings, limits=limits)


def rescued_matches(
    reference: ReferencePicture,
    deformed: DeformedPicture,
    grid: PointGrid,
    found: GridMatches,
    *,
    settings: SubsetSettings,
    limits: Limits,
) -> GridMatches:
    """Match lost points again from what their neighbours say, while that brings some back."""
    for _ in range(RESCUES):
        lost = np.argwhere(~found.ok & ~np.isin(found.status, HOPELESS))
        start, slope, known = neighbour_guesses(
            found.position, found.gradient, found.ok, lost, spacing=grid.spacing
        )
        lost, start, slope = lost[known], start[known], slope[known]
        if len(lost) == 0:
            break
        at = grid.points[tuple(lost.T)]
        starts = affine_starts(at, start, slope)
        again = match_points(reference, deformed, at, starts, settings=settings)
        before = int(found.ok.sum())
        found = judged_matches(merged_matches(found, again, lost), grid.spacing, limits)
        if int(found.ok.sum()) <= before:
            break
    return found


def empty_matches(grid: PointGrid) -> GridMatches:
    """Nothing matched yet; points inside are NOT_SEEDED."""
    shape = grid.inside.shape
    status = np.where(grid.inside, PointStatus.NOT_SEEDED, PointStatus.OUTSIDE_MASK)
    return GridMatches(
        position=grid.points.astype(np.float64),
        gradient=np.broadcast_to(np.eye(2), (*shape, 2, 2)).copy(),
        warps=identity_starts(grid.inside.size).reshape(*shape, 12),
        zncc=np.full(shape, np.nan),
        iterations=np.zeros(shape, dtype=np.int64),
        status=status.astype(np.uint8),
        seconds=0.0,
    )


def merged_matches(grid: GridMatches, matches: SubsetMatches, chosen: Ints) -> GridMatches:
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
    return GridMatches(position, gradient, warps, zncc, iterations, status, seconds, grid.look)


def judged_matches(found: GridMatches, spacing: int, limits: Limits) -> GridMatches:
    """Check what converged against the ZNCC limit and its neighbours."""
    again = np.where(found.status == PointStatus.OUTLIER, np.uint8(PointStatus.OK), found.status)
    status = judge_zncc(again, found.zncc, min_zncc=limits.min_zncc)
    outlier, look = find_outliers(
        found.position,
        found.gradient,
        status,
        spacing=spacing,
        floor=limits.outlier_floor,
        before=found.look,
    )
    return replace(
        found, status=np.where(outlier, np.uint8(PointStatus.OUTLIER), status), look=look
    )
