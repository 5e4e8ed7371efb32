"""A crude warp made right: searched far, then near, until it stays where it is.

What a law says may be many pixels off. Every point of a grid is searched through it,
first within a wide circle; where points agree with each other the warp is fitted to them,
and from there the next search goes on outwards. What comes out depends on the pictures,
not on the law.
"""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.methods.consistency import consistent_pairs
from shapemorph.methods.contrast import Pattern, even_contrast
from shapemorph.methods.densify import (
    GridSearch,
    error_of_warp,
    grid_points,
    nearest_distance,
    search_grid,
)
from shapemorph.methods.speckle_ellipse import measure_speckle
from shapemorph.methods.warp_fit import fit_warp
from shapemorph.methods.warping import warp_points

# Lengths are in standard deviations of the speckle unless they say px.
LIGHT_WINDOW = 27.0
WORK_STD = 1.8  # px: coarser speckle is searched in reduced pictures
WINDOW = 15.0
RADII = (4.5, 9.0, 20.0)  # of the search: as far as the last round says is needed
STRIDE = 1.3
STEP, FAR_STEP, LEAST_STEP = 7.0, 11.0, 3.0
ENOUGH_POINTS = 800
MOST_POINTS = {4.5: 8000, 9.0: 2500, 20.0: 900}
LEAST_INSIDE, LEAST_ZNCC = 0.4, 0.6
NEIGHBOURS, LEAST_PAIRS = 24, 12  # that predict a point; without which nothing is fitted
SETTLED = 0.1  # px
GROWN = 0.02  # share of the grid by which a round must extend the warp to be worth another
ROUNDS = 12
FOUND = 0.15  # share of the grid, else a law has not led anywhere
WELL_INSIDE = 0.4  # of the radius of a search: shifts below it need no wider one


@dataclass(frozen=True, slots=True, eq=False)
class SettledWarp:
    """A warp that the pictures agree with.

    Attributes
    ----------
    warp : Warp
    found : float
        Share of the grid points that were found through it.
    added : int
        Matches that had to be added where the law led nowhere.
    source, target : (N, 2) float64
        Points that were found through it, px.
    """

    warp: Warp
    found: float
    added: int
    source: Floats
    target: Floats


@dataclass(frozen=True, slots=True, eq=False)
class _Pictures:
    """Both patterns and the size of the speckle, px of the reference."""

    reference: Pattern
    deformed: Pattern
    std: float


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """The warp so far, where it is known to be right, and how far off it was, px."""

    warp: Warp
    known: Floats
    target: Floats
    share: float = 0.0
    moved: float = np.inf
    farthest: float = np.inf
    fine: bool = False


def settle_warp(
    reference: GreyImage,
    deformed: GreyImage,
    warp: Warp,
    matches: tuple[Floats, Floats],
    *,
    near: bool = False,
) -> SettledWarp:
    """Correct a warp until searching through it changes nothing more.

    Parameters
    ----------
    reference, deformed : GreyImage
    warp : Warp
        Reference -> deformed, as a law has it: off by up to some twenty standard deviations
        of the speckle, or more where a part of it is that good and the rest can be reached
        from there.
    matches : two (N, 2) arrays
        Pairs of positions, px; they count only where the law leads nowhere.
    near : bool
        Search near first: the warp is off by a few standard deviations at most, and the
        pattern may repeat farther away.

    Raises
    ------
    StageError
        If neither the law nor the matches lead anywhere.
    """
    pictures = _prepare(reference, deformed)
    state = _follow(pictures, _begin(pictures, warp, 0.0 if near else np.inf))
    source, target = _missing(pictures, state, matches)
    if len(source):
        joined = np.concatenate([state.known, source]), np.concatenate([state.target, target])
        warp = _fitted(pictures, *joined, FAR_STEP * pictures.std)
        state = _follow(pictures, _State(warp, *joined, farthest=0.0))
    if state.share < FOUND:
        raise StageError(
            f"the morph law leads nowhere: only {state.share:.0%} of the points are found through "
            f"it, at least {FOUND:.0%} are needed; use morph.law=warp, or correct the law"
        )
    return SettledWarp(state.warp, state.share, len(source), state.known, state.target)


def _prepare(reference: GreyImage, deformed: GreyImage) -> _Pictures:
    std = _speckle(reference)
    window = 2 * int(np.clip(LIGHT_WINDOW * std, 24, 240) / 2) + 1
    other = 2 * int(np.clip(LIGHT_WINDOW * _speckle(deformed), 24, 240) / 2) + 1
    return _Pictures(
        even_contrast(reference, window=window), even_contrast(deformed, window=other), std
    )


def _speckle(image: GreyImage) -> float:
    field = measure_speckle(even_contrast(image, window=49), window=128.0)
    if field is None:
        raise StageError("a picture is blank: expected a pattern that can be searched")
    return float(field.std)


def _begin(pictures: _Pictures, warp: Warp, farthest: float) -> _State:
    """Believe the law everywhere, to within `farthest` px."""
    step = _clipped_step(pictures, STEP * pictures.std, MOST_POINTS[RADII[0]])
    everywhere = grid_points(pictures.reference.mask, step)
    return _State(warp, everywhere, everywhere, farthest=farthest)


def _follow(pictures: _Pictures, state: _State) -> _State:
    """Search and fit until nothing moves and nothing is gained."""
    for _ in range(ROUNDS):
        before = state
        state = _round(pictures, before)
        grown = state.share > before.share + GROWN
        if len(state.known) == 0 or (state.fine and state.moved < SETTLED and not grown):
            break
    return state


def _round(pictures: _Pictures, state: _State) -> _State:
    radius = next((r for r in RADII if state.farthest < WELL_INSIDE * r * pictures.std), RADII[-1])
    how = _search(pictures, state.warp, radius)
    found = search_grid(pictures.reference, pictures.deformed, state.warp, state.known, how)
    good = consistent_pairs(
        found.source,
        found.source + found.shift,
        neighbours=NEIGHBOURS,
        tolerance=0.5 * pictures.std,
        cap=pictures.std if radius == RADII[0] else 2.0 * pictures.std,
    )
    source, target = found.source[good], found.target[good]
    possible = len(grid_points(pictures.reference.mask, how.step))
    if len(source) < LEAST_PAIRS:
        nothing = np.zeros((0, 2))
        return _State(state.warp, nothing, nothing)
    warp = _fitted(pictures, source, target, how.step)
    change = warp_points(warp, source)[0] - warp_points(state.warp, source)[0]
    return _State(
        warp,
        source,
        target,
        share=len(source) / possible,
        moved=float(np.median(np.linalg.norm(change, axis=1))),
        farthest=float(np.percentile(np.linalg.norm(found.shift[good], axis=1), 99)),
        fine=radius == RADII[0],
    )


def _fitted(pictures: _Pictures, source: Floats, target: Floats, step: float) -> Warp:
    """Smooth warp through what was found, over the whole reference picture."""
    spacing = 2.0 * step
    high = np.array(pictures.reference.shape[::-1]) - 1.0
    extent = (-np.full(2, spacing), high + spacing)
    return fit_warp(source, target, extent=extent, spacing=spacing, smoothing=None)


def _search(pictures: _Pictures, warp: Warp, radius: float) -> GridSearch:
    """Sizes of grid, window and search; the wider the search, the fewer points."""
    reduction = max(1, round(pictures.std / WORK_STD))
    std = pictures.std / reduction
    stride = max(1, round(STRIDE * std))
    most = MOST_POINTS[radius]
    widest = (STEP if radius == RADII[0] else FAR_STEP) * pictures.std
    step = _clipped_step(pictures, widest, most)
    return GridSearch(
        step=step,
        reach=max(3 * step, 2 * warp.spacing) if radius == RADII[0] else 3 * step,
        reduction=reduction,
        half=max(7, round(WINDOW * std / 2)),
        radius=stride * max(1, round(radius * std / stride)),
        stride=stride,
        least_inside=LEAST_INSIDE,
        least_zncc=LEAST_ZNCC,
    )


def _clipped_step(pictures: _Pictures, widest: float, most: int) -> float:
    """Grid step, px: less where a small picture would have few points, more against too many."""
    area = float(pictures.reference.mask.sum())
    enough = max(LEAST_STEP * pictures.std, np.sqrt(area / ENOUGH_POINTS))
    return float(max(min(widest, enough), np.sqrt(area / most)))


def _missing(
    pictures: _Pictures, state: _State, matches: tuple[Floats, Floats]
) -> tuple[Floats, Floats]:
    """Choose matches that the warp, as far as it is known, does not reach or contradicts."""
    source, target = matches
    if len(source) == 0 or len(state.known) == 0:
        return source, target
    lonely = nearest_distance(state.known, source) > 2 * FAR_STEP * pictures.std
    off = np.linalg.norm(error_of_warp(state.warp, source, target), axis=1)
    missing = lonely & (off > pictures.std)
    return source[missing], target[missing]
