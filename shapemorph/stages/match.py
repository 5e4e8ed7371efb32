"""Stage `match`: two pictures of one material to pairs of points and smooth warps."""

import logging
from dataclasses import dataclass, field

import numpy as np

from shapemorph.config import MatchConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.core.image import GreyImage
from shapemorph.core.laws import Dots
from shapemorph.core.matching import Matches, UnmatchedError, Warp
from shapemorph.methods.consistency import consistent_pairs
from shapemorph.methods.densify import (
    GridSearch,
    GridSeeds,
    error_of_warp,
    nearest_distance,
    search_grid,
)
from shapemorph.methods.first_pairs import CELL, NEIGHBOURS, Side
from shapemorph.methods.repetition import doubt_of_repeat, find_repeat
from shapemorph.methods.second_tries import Start, find_start, in_fine_detail, what_is_wrong
from shapemorph.methods.warp_fit import WarpFit, fit_warp_checked, fold_share
from shapemorph.methods.warping import warp_points

_log = logging.getLogger(__name__)

# Lengths below are in standard deviations of the speckle (its width at half maximum is 3.3
# of them) unless they say px.
ENOUGH_PAIRS = 40  # with so many first ones no other way of matching is tried
WORK_STD = 1.8  # px: coarser speckle is searched in reduced pictures
FIRST_STEP, STEP = 11.0, 7.0
LEAST_STEP = 3.0  # where the picture is small for its speckle
ENOUGH_GRID_POINTS, MOST_GRID_POINTS = (500, 1_500), 8_000
WINDOW = 15.0
FIRST_RADIUS, RADIUS = 4.5, 2.2
SEARCH_STRIDE = 1.3
LEAST_INSIDE, LEAST_ZNCC = 0.4, 0.6
LEAST_FOUND = 0.15  # share of the searched grid points, else the warp is not believed
MOST_SCATTER = 1.0  # px about the warp, median: more is not believed
LOOSE, LOOSEST = 0.3, 95.0  # px that this percentile may be off the warp without a doubt


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Pairs of points so far, with the warp through them."""

    source: Floats
    target: Floats
    fit: WarpFit
    counts: dict[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class _Settled:
    """Pairs whose warp has settled, and how far it moved last, px."""

    pairs: _Pairs
    moved: float

    @property
    def residual(self) -> float:
        """Distance of a pair from the warp without it, px, median."""
        return float(np.median(self.pairs.fit.left_out))

    @property
    def loose(self) -> float:
        """Distance that one pair in twenty exceeds, px."""
        return float(np.percentile(self.pairs.fit.left_out, LOOSEST))


def match(
    reference: GreyImage,
    deformed: GreyImage,
    config: MatchConfig,
    known: Dots | None = None,
    found: Dots | None = None,
) -> Matches:
    """Find hundreds to thousands of pairs that show the same material.

    The speckle of both pictures is made round, features are matched and voted on, a
    smooth warp is fitted, and a grid of points is searched through it until the warp
    stays where it is.

    Parameters
    ----------
    reference, deformed : GreyImage
        Two pictures of one pattern, at any rotation, scale and stretch; not mirrored.
    config : MatchConfig
        Section ``match``.
    known : Dots or None
        Pairs that are roughly right, from marks or a model: used where features are too few.
    found : Dots or None
        Features that were matched before: none are sought where these lie all over the picture.

    Returns
    -------
    Matches
        Positions in px of the two pictures.

    Raises
    ------
    StageError
        If a picture is blank or too few pairs agree with each other.
    """
    enough = max(ENOUGH_PAIRS, 2 * config.min_matches)
    start = find_start(
        reference, deformed, ratio=config.ratio, enough=enough, known=known, found=found
    )
    try:
        _refuse_few_on_a_repeat(start, enough)
        return _extend(start, config, (reference, deformed))
    except StageError as error:
        message = _why_not(start, config) or str(error)
        raise UnmatchedError(message, *start.pairs.alike.swapaxes(0, 1)) from error


def _refuse_few_on_a_repeat(start: Start, enough: int) -> None:
    """Raise where a whole part of the picture could lie one repeat off and agree with itself."""
    few = len(start.pairs) < enough
    if few and find_repeat(start.left.pattern, std=start.left.std) is not None:
        raise StageError("too few pairs for a pattern that repeats")


def _why_not(start: Start, config: MatchConfig) -> str:
    """Say what is wrong with two pictures that do not match; empty if nothing special."""
    cause = what_is_wrong(start, ratio=config.ratio, needed=config.min_matches)
    if cause:
        return _refusal(cause, start.pairs.counts)
    repeat = find_repeat(start.left.pattern, std=start.left.std)
    if repeat is None:
        return ""
    length = float(np.linalg.norm(repeat))
    cause = f"the pattern repeats every {length:.0f} px: add speckle that does not"
    return _refusal(cause, start.pairs.counts)


def _extend(start: Start, config: MatchConfig, images: tuple[GreyImage, GreyImage]) -> Matches:
    """Search the whole picture through the warp of the first pairs, and settle.

    Where that leaves the pairs loose, coarse clouds may have led them: the fine detail is
    searched through the warp so far, and serves if it holds the pairs better.
    """
    settled = _settle(start, _first_warp(start, config), config)
    if settled.loose > LOOSE and not start.fine:
        finer = in_fine_detail(start, images)
        try:
            held = _settle(finer, settled.pairs, config)
        except StageError as error:
            _log.info("fine detail does not hold the pairs: %s", error)
        else:
            if held.loose < settled.loose:
                return _finish(finer, held)
    return _finish(start, settled)


def _settle(start: Start, pairs: _Pairs, config: MatchConfig) -> _Settled:
    """Search through the warp again and again, until it stays where it is."""
    features = pairs.source, pairs.target
    moved = np.inf
    for number in range(config.max_rounds):
        before = pairs.fit.warp
        pairs = _search_round(start.left, start.right, pairs, features, config, first=number == 0)
        moved = _median_change(before, pairs.fit.warp, pairs.source)
        _log.info("round %d: %d pairs, moved %.3f px", number + 1, len(pairs.source), moved)
        if number > 0 and moved < config.settle_px:
            break
    return _Settled(pairs, moved)


def _first_warp(start: Start, config: MatchConfig) -> _Pairs:
    """Fit the warp through features that agree with their neighbours."""
    found, left = start.pairs, start.left
    _require(len(found), found.counts, config)
    gap = np.sqrt(left.pattern.mask.sum() / len(found))
    fit = _fit(left, found.source, found.target, max(CELL * left.std, 2 * gap))
    return _Pairs(found.source, found.target, fit, found.counts)


def _search_round(
    left: Side,
    right: Side,
    pairs: _Pairs,
    features: tuple[Floats, Floats],
    config: MatchConfig,
    *,
    first: bool,
) -> _Pairs:
    """Search a grid through the warp so far and fit the next warp through what agrees."""
    how = _grid_search(left, pairs.fit.warp, first=first)
    found = search_grid(left.pattern, right.pattern, pairs.fit.warp, pairs.source, how)
    counts = {**pairs.counts, "searched": found.asked, "densified": len(found.source)}
    source, target, shift = _with_features(found, pairs.fit.warp, features, 1.25 * how.step)
    good = consistent_pairs(
        source,
        source + shift,
        neighbours=NEIGHBOURS[1],
        tolerance=0.5 * left.std,
        cap=left.std,
    )
    source, target = source[good], target[good]
    counts["kept"] = len(source)
    _require(len(source), counts, config)
    _require_found(counts)
    smoothing = None if first else pairs.fit.smoothing  # chosen once for grid points
    return _Pairs(source, target, _fit(left, source, target, 2 * how.step, smoothing), counts)


def _grid_search(side: Side, warp: Warp, *, first: bool) -> GridSearch:
    """Sizes of grid, window and search for the speckle of the reference picture."""
    reduction = max(1, round(side.narrowest / WORK_STD))
    work_std = side.std / reduction
    stride = max(1, round(SEARCH_STRIDE * side.narrowest / reduction))
    area = float(side.pattern.mask.sum())
    enough = ENOUGH_GRID_POINTS[0] if first else ENOUGH_GRID_POINTS[1]
    finer = max(LEAST_STEP * side.std, np.sqrt(area / enough))
    step = min(side.std * (FIRST_STEP if first else STEP), finer)
    step = max(step, np.sqrt(area / MOST_GRID_POINTS))
    return GridSearch(
        step=step,
        reach=max(3 * step, 2 * warp.spacing),
        reduction=reduction,
        half=max(7, round(WINDOW * work_std / 2)),
        radius=stride * max(1, round((FIRST_RADIUS if first else RADIUS) * work_std / stride)),
        stride=stride,
        least_inside=LEAST_INSIDE,
        least_zncc=LEAST_ZNCC,
    )


def _with_features(
    found: GridSeeds, warp: Warp, features: tuple[Floats, Floats], apart: float
) -> tuple[Floats, Floats, Floats]:
    """Source, target and shift of the grid points, and of features where there are none."""
    source, target = features
    if len(found.source):
        lonely = nearest_distance(found.source, source) > apart
        source, target = source[lonely], target[lonely]
    shift = error_of_warp(warp, source, target)
    return (
        np.concatenate([found.source, source]),
        np.concatenate([found.target, target]),
        np.concatenate([found.shift, shift]),
    )


def _fit(
    side: Side, source: Floats, target: Floats, spacing: float, smoothing: float | None = None
) -> WarpFit:
    high = np.array(side.pattern.shape[::-1]) - 1.0
    return fit_warp_checked(
        source,
        target,
        extent=(-np.full(2, spacing), high + spacing),
        spacing=spacing,
        smoothing=smoothing,
    )


def _median_change(before: Warp, after: Warp, points: Floats) -> float:
    change = warp_points(after, points)[0] - warp_points(before, points)[0]
    return float(np.median(np.linalg.norm(change, axis=1)))


def _require(number: int, counts: dict[str, int], config: MatchConfig) -> None:
    if number < config.min_matches:
        raise StageError(_too_few(f"{number} pairs agree, {config.min_matches} are needed", counts))


def _require_found(counts: dict[str, int]) -> None:
    if counts["kept"] < LEAST_FOUND * counts["searched"]:
        raise StageError(_too_few("the pairs do not extend to their surroundings", counts))


def _too_few(what: str, counts: dict[str, int]) -> str:
    return _refusal(what, counts) + (
        "; check that both show the same object with a pattern, or raise match.ratio or "
        "flatten.px_per_mm"
    )


def _refusal(what: str, counts: dict[str, int]) -> str:
    steps = ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in counts.items())
    return f"the two pictures could not be matched: {what} ({steps})"


def _finish(start: Start, settled: _Settled) -> Matches:
    """Fit the way back and say how sound the result is."""
    pairs, left, right = settled.pairs, start.left, start.right
    forward, residual = pairs.fit.warp, settled.residual
    if residual > MOST_SCATTER:
        raise StageError(_too_few(f"the pairs scatter by {residual:.1f} px", pairs.counts))
    repeat = doubt_of_repeat(
        left.pattern,
        right.pattern,
        forward,
        pairs.source,
        _grid_search(left, forward, first=True),
        left.std,
    )
    _targets, gradient = warp_points(forward, pairs.source)
    growth = float(np.sqrt(np.median(np.abs(np.linalg.det(gradient)))))
    backward = _fit(
        right, pairs.target, pairs.source, forward.spacing * growth, pairs.fit.smoothing
    )
    return Matches(
        reference_px=pairs.source,
        deformed_px=pairs.target,
        forward=forward,
        backward=backward.warp,
        counts=pairs.counts,
        settled_px=settled.moved,
        residual_px=residual,
        doubt="; ".join(each for each in (repeat, _doubt_of_scatter(settled.loose)) if each),
        fold_share=fold_share(forward, left.pattern.mask, pairs.source, reach=forward.spacing),
        manner=start.manner,
    )


def _doubt_of_scatter(loose: float) -> str:
    if loose <= LOOSE:
        return ""
    return (
        f"the pattern holds some pairs only to {loose:.1f} px (5 % are off the warp by more), as "
        "long grain, coarse clouds and very large stretches do: a finer pattern helps"
    )
