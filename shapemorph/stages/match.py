"""Stage `match`: two pictures of one material to pairs of points and smooth warps."""

import logging
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from shapemorph.config import MatchConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Matches, Warp
from shapemorph.methods.consistency import consistent_pairs, frame_support
from shapemorph.methods.contrast import Pattern, even_contrast
from shapemorph.methods.densify import (
    GridSearch,
    GridSeeds,
    error_of_warp,
    nearest_distance,
    search_grid,
)
from shapemorph.methods.descriptor_match import match_descriptors
from shapemorph.methods.features import Features, detect_features
from shapemorph.methods.speckle_ellipse import SpeckleField, measure_speckle
from shapemorph.methods.views import round_views
from shapemorph.methods.warp_fit import WarpFit, fit_warp_checked, fold_share
from shapemorph.methods.warping import warp_points

_log = logging.getLogger(__name__)

# Lengths below are in standard deviations of the speckle (its width at half maximum is 3.3
# of them) unless they say px.
LIGHT_WINDOW = 27.0
SPECKLE_WINDOW = 66.0
VIEW_STD = 1.5  # px
CELL = 22.0
PER_CELL = (6.0, 9.6)
MOST_FEATURES = (6000, 9600)
SAME_PLACE = 1.7
NEIGHBOURS = (16, 24)  # that vote, that predict
SUPPORT = 0.25
WORK_STD = 1.8  # px: coarser speckle is searched in reduced pictures
FIRST_STEP, STEP = 11.0, 7.0
LEAST_STEP = 3.0  # where the picture is small for its speckle
ENOUGH_GRID_POINTS, MOST_GRID_POINTS = 1_500, 8_000
WINDOW = 15.0
FIRST_RADIUS, RADIUS = 4.5, 2.2
SEARCH_STRIDE = 1.3
LEAST_INSIDE, LEAST_ZNCC = 0.4, 0.6
LEAST_CONTRAST = 1.0 / 255
LEAST_FOUND = 0.15  # share of the searched grid points, else the warp is not believed


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """One picture, its pattern and the shape of its speckle."""

    pattern: Pattern
    speckle: SpeckleField

    @property
    def std(self) -> float:
        return self.speckle.std


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Pairs of points so far, with the warp through them."""

    source: Floats
    target: Floats
    fit: WarpFit
    counts: dict[str, int] = field(default_factory=dict)


def match(reference: GreyImage, deformed: GreyImage, config: MatchConfig) -> Matches:
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

    Returns
    -------
    Matches
        Positions in px of the two pictures.

    Raises
    ------
    StageError
        If a picture is blank or too few pairs agree with each other.
    """
    with ThreadPoolExecutor(2) as pool:
        left, right = pool.map(_measure, (reference, deformed), ("reference", "deformed"))
    pairs = _first_pairs(left, right, config)
    features = pairs.source, pairs.target
    settled = np.inf
    for number in range(config.max_rounds):
        before = pairs.fit.warp
        pairs = _search_round(left, right, pairs, features, config, first=number == 0)
        settled = _median_change(before, pairs.fit.warp, pairs.source)
        _log.info("round %d: %d pairs, moved %.3f px", number + 1, len(pairs.source), settled)
        if number > 0 and settled < config.settle_px:
            break
    return _finish(left, right, pairs, settled)


def _measure(image: GreyImage, name: str) -> _Side:
    """Even out the light over windows that suit the speckle, and measure its shape."""
    side = _measure_once(image, 49, 128.0, name)
    window = 2 * int(np.clip(LIGHT_WINDOW * side.std, 24, 240) / 2) + 1
    return _measure_once(image, window, float(np.clip(SPECKLE_WINDOW * side.std, 64, 512)), name)


def _measure_once(image: GreyImage, light: int, window: float, name: str) -> _Side:
    pattern = even_contrast(image, window=light)
    speckle = None
    if pattern.contrast >= LEAST_CONTRAST:
        speckle = measure_speckle(pattern, window=window)
    if speckle is None:
        raise StageError(
            f"the {name} picture is blank: its contrast is {255 * pattern.contrast:.2f} grey "
            f"levels of 255, at least {255 * LEAST_CONTRAST:.0f} are needed; is its texture right?"
        )
    return _Side(pattern, speckle)


def _first_pairs(left: _Side, right: _Side, config: MatchConfig) -> _Pairs:
    """Features that look alike and agree with their neighbours."""
    growth = (right.std / left.std) ** 2
    with ThreadPoolExecutor(2) as pool:
        per_cell = (
            PER_CELL[0] * np.sqrt(np.clip(growth, 1, 4)),
            PER_CELL[1] * np.clip(1 / growth, 1, 4),
        )
        ours, theirs = pool.map(_features, (left, right), per_cell, MOST_FEATURES)
    i, j = match_descriptors(ours, theirs, ratio=config.ratio, apart=SAME_PLACE * right.std)
    source, target = ours.points[i], theirs.points[j]
    counts = {
        "features_reference": len(ours),
        "features_deformed": len(theirs),
        "matched": len(i),
    }
    frames = theirs.frames[j] @ np.linalg.inv(ours.frames[i])
    support = frame_support(
        source, target, frames, neighbours=NEIGHBOURS[0], relative=0.25, absolute=2 * right.std
    )
    source, target = source[support >= SUPPORT], target[support >= SUPPORT]
    counts["voted"] = len(source)
    _require(len(source), counts, config)
    good = consistent_pairs(
        source, target, neighbours=NEIGHBOURS[1], tolerance=right.std, cap=3 * right.std
    )
    source, target = source[good], target[good]
    counts["consistent"] = len(source)
    _require(len(source), counts, config)
    gap = np.sqrt(left.pattern.mask.sum() / len(source))
    return _Pairs(source, target, _fit(left, source, target, max(CELL * left.std, 2 * gap)), counts)


def _features(side: _Side, per_cell: float, most: int) -> Features:
    cells = side.pattern.mask.sum() / (CELL * side.std) ** 2
    wider = np.sqrt(max(1.0, cells * per_cell / most))
    return detect_features(
        round_views(side.pattern, side.speckle, std=VIEW_STD),
        contrast=0.02,
        cell=CELL * side.std * wider,
        per_cell=round(per_cell),
    )


def _search_round(
    left: _Side,
    right: _Side,
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


def _grid_search(side: _Side, warp: Warp, *, first: bool) -> GridSearch:
    """Sizes of grid, window and search for the speckle of the reference picture."""
    reduction = max(1, round(side.std / WORK_STD))
    work_std = side.std / reduction
    stride = max(1, round(SEARCH_STRIDE * work_std))
    area = float(side.pattern.mask.sum())
    finer = max(LEAST_STEP * side.std, np.sqrt(area / ENOUGH_GRID_POINTS))
    step = min(side.std * (FIRST_STEP if first else STEP), finer if not first else np.inf)
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
    side: _Side, source: Floats, target: Floats, spacing: float, smoothing: float | None = None
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
    steps = ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in counts.items())
    return (
        f"the two pictures could not be matched: {what} ({steps}); check that both show the same "
        "object, neither mirrored nor without pattern, or raise match.ratio or flatten.px_per_mm"
    )


def _finish(left: _Side, right: _Side, pairs: _Pairs, settled: float) -> Matches:
    """Fit the way back and say how sound the result is."""
    forward = pairs.fit.warp
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
        settled_px=settled,
        residual_px=float(np.median(pairs.fit.left_out)),
        fold_share=fold_share(forward, left.pattern.mask, pairs.source, reach=forward.spacing),
    )
