"""Pairs of points that look alike in two pictures and agree with their neighbours.

The steps are apart, so that the features of one picture can be matched with those of
several others: :func:`measure_side`, :func:`side_features`, :func:`pair_features`.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.core.image import GreyImage
from shapemorph.methods.consistency import consistent_pairs, frame_support
from shapemorph.methods.contrast import Pattern, even_contrast
from shapemorph.methods.descriptor_match import match_descriptors
from shapemorph.methods.features import Features, detect_features
from shapemorph.methods.speckle_ellipse import SpeckleField, measure_speckle, without_blur
from shapemorph.methods.views import SHARP, Softness, measure_in_view, round_views, rounding

# Lengths below are in standard deviations of the speckle (its width at half maximum is 3.3
# of them) unless they say px.
LIGHT_WINDOW = 27.0
SPECKLE_WINDOW = 66.0
FINE_WINDOW, FINE_STD, FINE_ROUNDS = 9.0, 3.0, 3  # the second in px
VIEW_STD = 1.5  # px
CELL = 22.0
PER_CELL = (6.0, 9.6)
MOST_FEATURES = (6000, 9600)
SAME_PLACE = 1.7
NEIGHBOURS = (16, 24)  # that vote, that predict
SUPPORT = 0.25
LEAST_CONTRAST = 1.0 / 255


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """One picture, its pattern and the shape of its speckle."""

    pattern: Pattern
    speckle: SpeckleField

    @property
    def std(self) -> float:
        """Standard deviation of a round speckle of the same area, px, median."""
        return self.speckle.std

    @property
    def narrowest(self) -> float:
        """Standard deviation of the speckle along its short axis, px, median."""
        return float(np.exp(0.5 * np.linalg.eigvalsh(self.speckle.median)[0]))


@dataclass(frozen=True, slots=True)
class Budget:
    """How many features a picture may have.

    Attributes
    ----------
    per_cell : float
        Features in a cell, whose width is 22 standard deviations of the speckle.
    most : int
        In the whole picture, about; beyond it cells are wider.
    """

    per_cell: float
    most: int


@dataclass(frozen=True, slots=True, eq=False)
class FirstPairs:
    """Pairs of features.

    Attributes
    ----------
    source, target : (N, 2) float64
        Positions in the two pictures, px.
    counts : dict of str to int
        Features left after each step, in order.
    alike : (M, 2, 2) float64
        Source and target of all features that look alike, before any vote, px.
    """

    source: Floats
    target: Floats
    counts: dict[str, int]
    alike: Floats

    def __len__(self) -> int:
        return len(self.source)


def first_pairs(left: Side, right: Side, *, ratio: float) -> FirstPairs:
    """Find the features of two pictures that look alike and agree with their neighbours.

    Parameters
    ----------
    left, right : Side
    ratio : float
        Largest allowed distance of the best descriptor over that of the second best.

    Returns
    -------
    FirstPairs
        None at all if the pictures have nothing in common.
    """
    with ThreadPoolExecutor(2) as pool:
        ours, theirs = pool.map(side_features, (left, right), budgets(left, right))
    return pair_features(ours, theirs, std=right.std, ratio=ratio)


def measure_side(image: GreyImage, name: str) -> Side:
    """Even out the light over windows that suit the speckle, and measure its shape.

    Parameters
    ----------
    image : GreyImage
    name : str
        What a message calls the picture.

    Raises
    ------
    StageError
        If the picture is blank.
    """
    side = _measure_once(image, 49, 128.0, name)
    window = 2 * int(np.clip(LIGHT_WINDOW * side.std, 24, 240) / 2) + 1
    return _measure_once(image, window, float(np.clip(SPECKLE_WINDOW * side.std, 64, 512)), name)


def measure_fine_side(image: GreyImage, name: str) -> Side:
    """Let fine detail speak in a texture that has all sizes, such as skin or wood.

    Contrast is made even over windows of few grains that are stretched like the grain
    itself, again and again until window and grain agree; so the result follows the
    material however long its grain is.

    Parameters
    ----------
    image : GreyImage
    name : str
        What a message calls the picture.

    Raises
    ------
    StageError
        If the picture is blank.
    """
    side = measure_side(image, name)
    for _ in range(FINE_ROUNDS):
        window = 2 * int(FINE_WINDOW * FINE_STD / 2) + 1
        matrix = rounding(side.speckle.median, FINE_STD)
        pattern = even_contrast(image, window=window, rounding=matrix)
        speckle = measure_in_view(pattern, matrix, window=SPECKLE_WINDOW * FINE_STD)
        if speckle is None:
            break
        side = Side(pattern, speckle)
    return side


def budgets(left: Side, right: Side) -> tuple[Budget, Budget]:
    """Features that both pictures should have: more in that which shows less at once."""
    growth = (right.std / left.std) ** 2
    return (
        Budget(PER_CELL[0] * np.sqrt(np.clip(growth, 1, 4)), MOST_FEATURES[0]),
        Budget(PER_CELL[1] * np.clip(1 / growth, 1, 4), MOST_FEATURES[1]),
    )


def side_features(side: Side, budget: Budget, softness: Softness = SHARP) -> Features:
    """Detect features where the speckle is made round.

    Parameters
    ----------
    side : Side
    budget : Budget
    softness : Softness
        Blur of the picture, and blur that the features shall be seen with.
    """
    speckle = without_blur(side.speckle, softness.lens) if softness.lens else side.speckle
    width = CELL * speckle.std * np.hypot(1.0, softness.wanted)
    cells = side.pattern.mask.sum() / width**2
    wider = np.sqrt(max(1.0, cells * budget.per_cell / budget.most))
    return detect_features(
        round_views(side.pattern, speckle, std=VIEW_STD, softness=softness),
        contrast=0.02,
        cell=width * wider,
        per_cell=round(budget.per_cell),
    )


def equally_soft(soft: Side, lens: float) -> tuple[Softness, Softness]:
    """Blur with which a sharp picture looks like one that is out of focus by `lens`, px.

    The soft one cannot be made sharper: its blur, seen where the sharp speckle would be
    round, is made round, and the sharp one is blurred as much.

    Returns
    -------
    tuple of Softness
        Of the sharp picture, of the soft one.
    """
    eigenvalues = np.exp(np.linalg.eigvalsh(without_blur(soft.speckle, lens).median))
    wanted = lens / float(np.sqrt(eigenvalues[0]))
    return Softness(0.0, wanted), Softness(lens, wanted)


def pair_features(ours: Features, theirs: Features, *, std: float, ratio: float) -> FirstPairs:
    """Match features of two pictures and let neighbours vote on the matches.

    Parameters
    ----------
    ours, theirs : Features
    std : float
        Standard deviation of the speckle in the second picture, px: the scale of all
        tolerances.
    ratio : float
        Largest allowed distance of the best descriptor over that of the second best.
    """
    found = voted_pairs(ours, theirs, std=std, ratio=ratio)
    source, target = ours.points[found.i], theirs.points[found.j]
    alike = np.stack([source, target], axis=1)
    counts = {"features_reference": len(ours), "features_deformed": len(theirs)}
    counts["matched"] = len(found.i)
    good = found.support >= SUPPORT
    source, target = source[good], target[good]
    counts["voted"] = len(source)
    good = consistent_pairs(source, target, neighbours=NEIGHBOURS[1], tolerance=std, cap=3 * std)
    counts["consistent"] = int(good.sum())
    return FirstPairs(source[good], target[good], counts, alike)


@dataclass(frozen=True, slots=True, eq=False)
class VotedPairs:
    """Features that look alike, and what their neighbours say.

    Attributes
    ----------
    i, j : (N,) int64
        Rows of the two sets of features.
    support : (N,) float64
        Share of the neighbours that agree about the local map; from 0.25 it counts.
    """

    i: Ints
    j: Ints
    support: Floats


def voted_pairs(ours: Features, theirs: Features, *, std: float, ratio: float) -> VotedPairs:
    """Match features of two pictures and let neighbours vote; see :func:`pair_features`."""
    i, j = match_descriptors(ours, theirs, ratio=ratio, apart=SAME_PLACE * std)
    frames = theirs.frames[j] @ np.linalg.inv(ours.frames[i])
    support = frame_support(
        ours.points[i],
        theirs.points[j],
        frames,
        neighbours=NEIGHBOURS[0],
        relative=0.25,
        absolute=2 * std,
    )
    return VotedPairs(i, j, support)


def _measure_once(image: GreyImage, light: int, window: float, name: str) -> Side:
    pattern = even_contrast(image, window=light)
    speckle = None
    if pattern.contrast >= LEAST_CONTRAST:
        speckle = measure_speckle(pattern, window=window)
    if speckle is None:
        raise StageError(
            f"the {name} picture is blank: its contrast is {255 * pattern.contrast:.2f} grey "
            f"levels of 255, at least {255 * LEAST_CONTRAST:.0f} are needed; is its texture right?"
        )
    return Side(pattern, speckle)
