"""What is tried when two pictures do not match the usual way, and why they may not."""

import logging
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from shapemorph.core.image import GreyImage
from shapemorph.core.laws import Dots
from shapemorph.methods.consistency import consistent_pairs
from shapemorph.methods.densify import grid_points, nearest_distance
from shapemorph.methods.features import Features
from shapemorph.methods.first_pairs import (
    CELL,
    NEIGHBOURS,
    Budget,
    FirstPairs,
    Side,
    budgets,
    equally_soft,
    measure_fine_side,
    measure_side,
    pair_features,
    side_features,
)
from shapemorph.methods.rough_start import settled_dots
from shapemorph.methods.simulated_views import simulated_pairs
from shapemorph.methods.views import SHARP, Softness

_log = logging.getLogger(__name__)

LENS = (2.0, 1.4)  # px: blur of one side that is tried
PLAUSIBLE = 1.2  # times the width of the narrowest speckle as measured: blur is not wider
GAP = 2.0  # cells; with features that were found before and leave no larger ones ...
REACHED = 0.93  # ... in so much of the picture, none are sought
FINE_PLENTY = 3.0  # cells suit the grain: its detail is finer, and much of it alike
CONVINCING = 2  # times the pairs that are needed, for saying what is wrong with a pair

FINE, USUAL = "fine detail", "features of round speckle"
MIRRORED = (
    "one is mirrored: flip one of them; if it is a mesh that is inside out, reverse the order of "
    "the corners of its faces"
)

Sides = tuple[Side, Side]


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """The first pairs of two pictures, and how both were looked at.

    Attributes
    ----------
    left, right : Side
    features : tuple of Features
        Of both.
    pairs : FirstPairs
    manner : str
        What was done to find them; empty the usual way.
    """

    left: Side
    right: Side
    features: tuple[Features, Features]
    pairs: FirstPairs
    manner: str

    @property
    def fine(self) -> bool:
        """Whether only the fine detail was looked at."""
        return FINE in self.manner


def in_fine_detail(start: Start, images: tuple[GreyImage, GreyImage]) -> Start:
    """Look at the fine detail of both pictures only, with the first pairs that there are."""
    sides = _measured(measure_fine_side, *images)
    manner = f"{start.manner or USUAL}, then {FINE}"
    return Start(*sides, start.features, start.pairs, manner)


def find_start(
    reference: GreyImage,
    deformed: GreyImage,
    *,
    ratio: float,
    enough: int,
    known: Dots | None = None,
    found: Dots | None = None,
) -> Start:
    """Find first pairs the usual way, and in other ways where these are too few.

    Parameters
    ----------
    reference, deformed : GreyImage
    ratio : float
        Largest allowed distance of the best descriptor over that of the second best.
    enough : int
        Pairs with which nothing else is tried.
    known : Dots or None
        Pairs that are roughly right, from marks or a model: used where features are too few.
    found : Dots or None
        Features that were matched before: none are sought where these lie all over the picture.

    Returns
    -------
    Start
        The first that has enough pairs, else that with most.

    Raises
    ------
    StageError
        If a picture is blank.
    """
    sides = _measured(measure_side, reference, deformed)
    taken = None if found is None else _taken_start(sides, found, enough)
    if taken:
        return taken
    best = _attempt(sides, _Way(""), ratio)
    if len(best.pairs) >= enough or what_is_wrong(best, ratio=ratio, needed=enough):
        return best
    for attempt in _attempts(sides, (reference, deformed), ratio):
        _log.info("%s: %d pairs", attempt.manner, len(attempt.pairs))
        if len(attempt.pairs) > len(best.pairs):
            best = attempt
        if len(best.pairs) >= enough:
            return best
    return _led_start(best, reference, deformed, known) or best


def _taken_start(sides: Sides, found: Dots, enough: int) -> Start | None:
    """Begin with features that were matched before, if they agree and leave no large gap."""
    left, right = sides
    good = consistent_pairs(
        found.reference_px,
        found.deformed_px,
        neighbours=NEIGHBOURS[1],
        tolerance=right.std,
        cap=3 * right.std,
    )
    source, target = found.reference_px[good], found.deformed_px[good]
    if len(source) < enough:
        return None
    grid = grid_points(left.pattern.mask, CELL * left.std)
    if (nearest_distance(source, grid) < GAP * CELL * left.std).mean() < REACHED:
        return None
    counts = {"features_before": len(good), "consistent": len(source)}
    pairs = FirstPairs(source, target, counts, np.stack([source, target], axis=1))
    nothing = Features(np.empty((0, 2)), np.empty((0, 128), np.float32), np.empty((0, 2, 2)))
    return Start(left, right, (nothing, nothing), pairs, "")


def _led_start(
    best: Start, reference: GreyImage, deformed: GreyImage, known: Dots | None
) -> Start | None:
    """Begin with what is known beforehand, if the pictures agree with it."""
    dots = None if known is None else settled_dots(reference, deformed, known)
    if dots is None:
        return None
    counts = {**best.pairs.counts, "led": len(dots.reference_px)}
    pairs = FirstPairs(dots.reference_px, dots.deformed_px, counts, best.pairs.alike)
    return Start(best.left, best.right, best.features, pairs, "marks or a model that were given")


def what_is_wrong(start: Start, *, ratio: float, needed: int) -> str:
    """Say whether one picture is the negative or the mirror image of the other.

    Descriptors of both are those of the picture itself in another order, so that nothing
    has to be detected again.

    Returns
    -------
    str
        Empty if it is neither.
    """
    ours, theirs = start.features
    suspects = {
        "the contrast of one is inverted: give one of them as its negative": negative(ours),
        MIRRORED: mirrored(ours),
        "one is mirrored and its contrast inverted: change both": negative(mirrored(ours)),
    }
    for sentence, changed in suspects.items():
        pairs = pair_features(changed, theirs, std=start.right.std, ratio=ratio)
        if len(pairs) >= max(CONVINCING * needed, CONVINCING * len(start.pairs)):
            return sentence
    return ""


def are_mirrored(reference: GreyImage, deformed: GreyImage, *, ratio: float, needed: int) -> bool:
    """Tell whether two pictures match only when one of them is seen from behind.

    Parameters
    ----------
    reference, deformed : GreyImage
    ratio : float
        As for :func:`find_start`.
    needed : int
        Pairs that a match takes.

    Raises
    ------
    StageError
        If a picture is blank.
    """
    start = find_start(reference, deformed, ratio=ratio, enough=CONVINCING * needed)
    return what_is_wrong(start, ratio=ratio, needed=needed) == MIRRORED


def negative(features: Features) -> Features:
    """Features as the negative of the picture would have them: turned by half a turn."""
    cells = features.descriptors.reshape(-1, 4, 4, 8)[:, ::-1, ::-1]
    descriptors = np.ascontiguousarray(cells).reshape(-1, 128)
    return Features(features.points, descriptors, -features.frames)


def mirrored(features: Features) -> Features:
    """Features as the picture with its left and right exchanged would have them, x = -x."""
    directions = -np.arange(8) % 8
    cells = features.descriptors.reshape(-1, 4, 4, 8)[:, ::-1][..., directions]
    descriptors = np.ascontiguousarray(cells).reshape(-1, 128)
    flip = np.diag([-1.0, 1.0])
    frames = np.ascontiguousarray(flip @ features.frames @ np.diag([1.0, -1.0]))
    return Features(np.ascontiguousarray(features.points @ flip), descriptors, frames)


@dataclass(frozen=True, slots=True)
class _Way:
    """A way of looking at two pictures."""

    manner: str
    softnesses: tuple[Softness, Softness] = (SHARP, SHARP)
    plenty: float = 1.0  # times the usual number of features


def _attempts(sides: Sides, images: tuple[GreyImage, GreyImage], ratio: float) -> Iterator[Start]:
    """Find first pairs in other ways than the usual one, the likeliest first."""
    for way in _soft_ways(sides):
        yield _attempt(sides, way, ratio)
    fine = _measured(measure_fine_side, *images)
    yield _attempt(fine, _Way(FINE, plenty=FINE_PLENTY), ratio)
    yield Start(*sides, *simulated_pairs(*sides, ratio=ratio), "simulated views")


def _soft_ways(sides: Sides) -> Iterator[_Way]:
    for lens in LENS:
        for name, soft in (("deformed", sides[1]), ("reference", sides[0])):
            narrowest = np.exp(np.linalg.eigvalsh(soft.speckle.median))[0]
            if lens < PLAUSIBLE * np.sqrt(narrowest):
                sharp, blurred = equally_soft(soft, lens)
                pair = (sharp, blurred) if name == "deformed" else (blurred, sharp)
                yield _Way(f"{name} picture out of focus by {lens:g} px", pair)


def _measured(
    measure: Callable[[GreyImage, str], Side], reference: GreyImage, deformed: GreyImage
) -> Sides:
    with ThreadPoolExecutor(2) as pool:
        left, right = pool.map(measure, (reference, deformed), ("reference", "deformed"))
    return left, right


def _attempt(sides: Sides, way: _Way, ratio: float) -> Start:
    given = [Budget(way.plenty * each.per_cell, each.most) for each in budgets(*sides)]
    with ThreadPoolExecutor(2) as pool:
        ours, theirs = pool.map(side_features, sides, given, way.softnesses)
    pairs = pair_features(ours, theirs, std=sides[1].std, ratio=ratio)
    return Start(*sides, (ours, theirs), pairs, way.manner)
