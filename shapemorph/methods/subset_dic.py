"""Subset correlation of points on a regular grid."""

import time
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Codes, Floats, Ints
from shapemorph.core.status import PointStatus
from shapemorph.kernels.icgn import match_subsets
from shapemorph.methods.spline_coefficients import CUBIC
from shapemorph.methods.spline_pictures import DeformedPicture, ReferencePicture
from shapemorph.methods.threads import run_blocks

MIN_DEVIATION = 1.0 / 255.0  # a subset with less contrast shows no pattern
UNUSUAL = 30.0  # times the usual lack of correlation is too much
BEST_LIMIT = 0.95  # a ZNCC above it is good enough in any picture
BLOCK = 512  # points that a thread takes at once: fewer, and threads wait for the interpreter
REACH = 4  # px beyond the drift that the spline needs


@dataclass(frozen=True, slots=True)
class SubsetSettings:
    """How subsets are matched.

    Attributes
    ----------
    radius : int
        The subset is 2 radius + 1 px wide.
    order : int
        Of the shape function: 0, 1 or 2.
    tolerance : float
        Stop when no corner of the subset moves farther, px.
    max_iterations : int
    min_inside : float
        Share of the subset's pixels that must lie inside both masks.
    max_drift : float
        Farthest a point may move from its start, px.
    degree : int
        Of the spline between the pixels: 3 or 5.
    """

    radius: int
    order: int
    tolerance: float
    max_iterations: int
    min_inside: float
    max_drift: float
    degree: int = CUBIC

    @property
    def min_count(self) -> float:
        """Fewest pixels that must count; the rim of a mask is inside but does not count."""
        width = 2 * self.radius + 1
        return max(self.min_inside * width * width - width, float(width))

    @property
    def pad(self) -> int:
        """Padding of pictures in which no subset is ever out of reach, px."""
        return self.radius + int(np.ceil(self.max_drift)) + REACH


@dataclass(frozen=True, slots=True, eq=False)
class SubsetMatches:
    """What became of a list of points.

    Attributes
    ----------
    position : (N, 2) float64
        Matched position (x, y), px; the last estimate where `status` is not OK.
    gradient : (N, 2, 2) float64
        d position[i] / d reference[j].
    warps : (N, 12) float64
        The whole subset warp, as the kernel has it.
    zncc : (N,) float64
    iterations : (N,) int64
    status : (N,) uint8
    seconds : float
        Time in the kernel.
    """

    position: Floats
    gradient: Floats
    warps: Floats
    zncc: Floats
    iterations: Ints
    status: Codes
    seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class PointGrid:
    """A regular grid of points.

    Attributes
    ----------
    points : (R, C, 2) int64
        Positions (x, y), whole multiples of the spacing, px.
    inside : (R, C) bool
        Points that are to be matched.
    spacing : int
        px.
    """

    points: Ints
    inside: Bools
    spacing: int


def grid_points(mask: Bools, *, spacing: int) -> PointGrid:
    """Lay a regular grid over the bounding box of a mask; points on the mask are inside."""
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if len(rows) == 0:
        nothing = np.zeros((0, 0), dtype=bool)
        return PointGrid(np.zeros((0, 0, 2), dtype=np.int64), nothing, spacing)
    x = _multiples(int(cols[0]), int(cols[-1]), spacing)
    y = _multiples(int(rows[0]), int(rows[-1]), spacing)
    return PointGrid(np.stack(np.meshgrid(x, y), axis=-1), mask[np.ix_(y, x)], spacing)


def _multiples(low: int, high: int, spacing: int) -> Ints:
    return np.arange(-(-low // spacing), high // spacing + 1, dtype=np.int64) * spacing


def identity_starts(number: int) -> Floats:
    """(N, 12) warps that leave every pixel where it is."""
    starts = np.zeros((number, 12))
    starts[:, 1] = starts[:, 8] = 1.0
    return starts


def affine_starts(points: Ints, position: Floats, gradient: Floats) -> Floats:
    """(N, 12) warps that carry `points` to `position` with a given (N, 2, 2) gradient."""
    starts = np.zeros((len(points), 12))
    starts[:, [0, 6]] = position - points
    starts[:, [1, 2, 7, 8]] = gradient.reshape(-1, 4)
    return starts


def match_points(
    reference: ReferencePicture,
    deformed: DeformedPicture,
    points: Ints,
    starts: Floats,
    *,
    settings: SubsetSettings,
) -> SubsetMatches:
    """Match the subsets around points of the reference picture.

    Parameters
    ----------
    reference, deformed : ReferencePicture, DeformedPicture
        Padded by ``settings.pad``.
    points : (N, 2)
        Centres (x, y), px.
    starts : (N, 12)
        See :func:`identity_starts` and :func:`affine_starts`.
    settings : SubsetSettings
    """
    at = np.ascontiguousarray(points + reference.pad)
    warps = np.array(starts, dtype=np.float64, order="C")
    zncc, iterations = np.full(len(at), np.nan), np.zeros(len(at), dtype=np.int64)
    status = np.zeros(len(at), dtype=np.uint8)

    def work(first: int, last: int) -> None:
        some = slice(first, last)
        match_subsets(
            reference.planes,
            reference.inside,
            reference.counts,
            deformed.coefficients,
            deformed.wide,
            deformed.inside,
            deformed.counts,
            at[some],
            settings.radius,
            settings.order,
            1 if settings.order == 2 else None,
            settings.tolerance,
            settings.max_iterations,
            settings.min_count,
            MIN_DEVIATION,
            settings.max_drift,
            warps[some],
            zncc[some],
            iterations[some],
            status[some],
        )

    work(0, 0)  # compiles where that has not been done, so that it is not timed
    start = time.perf_counter()
    run_blocks(work, len(at), block=BLOCK)
    seconds = time.perf_counter() - start
    position = points + warps[:, [0, 6]]
    gradient = warps[:, [1, 2, 7, 8]].reshape(-1, 2, 2)
    return SubsetMatches(position, gradient, warps, zncc, iterations, status, seconds)


def judge_zncc(status: Codes, zncc: Floats, *, min_zncc: float) -> Codes:
    """Lower OK to LOW_ZNCC where the correlation is below a limit, or far below the usual.

    Where most subsets match almost perfectly, one that matches only well contains
    something foreign: a print, glare, the edge of a lost patch.
    """
    ok = status == PointStatus.OK
    usual = float(np.median(zncc[ok])) if np.isfinite(zncc[ok]).any() else 1.0
    relative = min(1.0 - UNUSUAL * (1.0 - usual), BEST_LIMIT)
    poor = ok & ~(zncc >= max(min_zncc, relative))
    return np.where(poor, np.uint8(PointStatus.LOW_ZNCC), status)
