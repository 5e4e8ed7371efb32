"""Which dots of a target the dots in rows and columns are."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.calibration import Target
from shapemorph.core.errors import DataError
from shapemorph.methods.cameras.closed_form import fit_homography, fit_projection
from shapemorph.methods.cameras.dots import Dots
from shapemorph.methods.cameras.lattice import Place, index_dots, stepped

_FEWEST = 6  # dots
_TRIED, _WORTH_A_TRY = 8, 0.2  # walks whose dots are named; share of the dots of the longest
_OVERLAP = 0.6  # of the dots seen: fewer on the target, and it is not this numbering
_RIVAL = 0.97  # of the dots of the best numbering: so many, and another is as good
_BESIDE = 1.5  # steps: the last column lies beside the first, the target goes all around
_AGAINST = 3.0  # dots that speak for a numbering and weigh as much as one against it
_FITS = 0.05  # of a step: rms of a numbering that may be right
_ROUNDS = 4
_OFF = 4.0  # times the median distance of dots to where a pinhole sees them
_LEAST_OFF = 2.0  # px
_SLANT = 0.5  # cosine: more slanted dots are thin, and a slip of the target moves them most
_TURNS = tuple(
    np.array(rows)
    for rows in (
        ((1, 0), (0, 1)),
        ((0, -1), (1, 0)),
        ((-1, 0), (0, -1)),
        ((0, 1), (-1, 0)),
        ((1, 0), (0, -1)),
        ((-1, 0), (0, 1)),
        ((0, 1), (1, 0)),
        ((0, -1), (-1, 0)),
    )
)


@dataclass(frozen=True, slots=True, eq=False)
class Anchor:
    """A dot whose name is known.

    Attributes
    ----------
    point : int
        Number of the point of the target.
    pixel : (2,) float64
        Roughly where it is seen.
    """

    point: int
    pixel: Floats


def identify(target: Target, spots: Dots, anchors: Sequence[Anchor]) -> tuple[Ints, Floats]:
    """Say which dots of a target were seen where.

    Every way to lay the rows and columns that were seen onto those of the target is tried.
    Dots that the target leaves out on purpose make one of them the best; where several are as
    good (a cylinder looks the same when it is turned by a column), named dots decide.

    Parameters
    ----------
    target : Target
        With a lattice.
    spots : Dots
        That were seen, others among them.
    anchors : sequence of Anchor

    Returns
    -------
    ids : (M,) int64
    pixels : (M, 2) float64

    Raises
    ------
    DataError
        If the target is not there, or several numberings are as good.
    """
    walks = index_dots(spots)
    most = len(walks[0][0]) if walks else 0
    if most < _FEWEST or target.lattice is None:
        raise DataError(
            f"expected rows and columns of dots, got {most} dots in a row of neighbours"
        )
    first: DataError | None = None
    for dots, steps in walks[:_TRIED]:
        if len(dots) < max(_FEWEST, _WORTH_A_TRY * most):
            continue
        try:
            return _identified(target, spots.centres, (dots, steps), anchors)
        except DataError as error:
            first = first or error
    assert first is not None
    raise first


def _identified(
    target: Target, centres: Floats, walk: tuple[Ints, Ints], anchors: Sequence[Anchor]
) -> tuple[Ints, Floats]:
    """Name the dots of one walk; see :func:`identify`."""
    (dots, steps), lattice = walk, target.lattice
    assert lattice is not None
    found = _numberings(target, lattice, centres[dots], steps, anchors)
    if not found:
        raise DataError(
            f"{len(dots)} dots in rows and columns do not fit the target"
            + (" and its anchors" if anchors else "")
        )
    wrap = _columns_around(target, lattice)
    scores = np.array([_score(lattice, way, wrap) for way in found])
    rivals = int((scores >= scores.max() - (1 - _RIVAL) * len(steps)).sum())
    if rivals > 1:
        raise DataError(
            f"{rivals} ways to number the dots are as good: name "
            "two of them in `anchors` (row, column, x, y)"
        )
    best = found[int(np.argmax(scores))].ids
    seen = best >= 0
    return complete(target, best[seen], centres[dots][seen], centres)


@dataclass(frozen=True, slots=True, eq=False)
class _Way:
    """A way to name the dots: number of the point (M,), -1 if none, and row and column (M, 2)."""

    ids: Ints
    places: Ints


def _columns_around(target: Target, lattice: Ints) -> int:
    """Columns of a target that goes all the way around, whose last is beside the first; else 0."""
    low, high = lattice[:, 1].min(), lattice[:, 1].max()
    first, last = (target.points[lattice[:, 1] == column] for column in (low, high))
    second = target.points[lattice[:, 1] == low + 1]
    if high - low < 3 or not len(second):
        return 0
    step = np.median(np.linalg.norm(first[:, None] - second[None], axis=-1).min(axis=1))
    gap = np.median(np.linalg.norm(first[:, None] - last[None], axis=-1).min(axis=1))
    return int(high - low + 1) if gap < _BESIDE * step else 0


def _score(lattice: Ints, way: _Way, wrap: int) -> float:
    """Count the dots that have a name, less those that contradict it.

    Contradictions are dots that were seen where the target leaves one out, and dots of the
    target that were not seen though all their neighbours were.
    """
    known, places = way.ids >= 0, _wrapped(way.places - lattice.min(axis=0), wrap)
    low, high = np.zeros(2, dtype=np.int64), lattice.max(axis=0) - lattice.min(axis=0)
    extra = ~known & ((places >= low) & (places <= high)).all(axis=1)
    seen = {tuple(place) for place in places.tolist()}
    unseen = [
        place
        for place in map(tuple, (lattice - lattice.min(axis=0)).tolist())
        if place not in seen and all(side in seen for side in _beside(place, wrap))
    ]
    return float(known.sum()) - _AGAINST * (int(extra.sum()) + len(unseen))


def _wrapped(places: Ints, wrap: int) -> Ints:
    """Take columns modulo those of a target that goes all the way around."""
    if not wrap:
        return places
    return np.stack([places[:, 0], places[:, 1] % wrap], axis=-1)


def _beside(place: Place, wrap: int) -> list[Place]:
    sides = [stepped(place, axis, sign) for axis in (0, 1) for sign in (1, -1)]
    return [(row, column % wrap) if wrap else (row, column) for row, column in sides]


def complete(target: Target, ids: Ints, pixels: Floats, centres: Floats) -> tuple[Ints, Floats]:
    """Drop what a pinhole does not see so, and take in all dots that it does.

    Parameters
    ----------
    target : Target
    ids : (M,) int64
    pixels : (M, 2)
        Most of them right, px.
    centres : (N, 2)
        All dots that were seen, px.

    Returns
    -------
    ids : (K,) int64
    pixels : (K, 2)
    """
    tree = cKDTree(centres)
    for _ in range(_ROUNDS):
        matrix = _fit(target, target.points[ids], pixels)
        rest = np.linalg.norm(_seen(matrix, target.points[ids]) - pixels, axis=1)
        limit = max(_OFF * float(np.median(rest)), _LEAST_OFF)
        matrix = _fit(target, target.points[ids[rest <= limit]], pixels[rest <= limit])
        expected = _seen(matrix, target.points)
        gaps, numbers = (np.asarray(part) for part in tree.query(expected))
        ids = np.flatnonzero((gaps <= limit) & _facing(target, matrix))
        pixels = centres[numbers[ids]]
    return ids, pixels


def _facing(target: Target, matrix: Floats) -> Bools:
    """Say which dots are seen, and not too slanted."""
    if target.normals is None:
        return np.ones(len(target.points), dtype=np.bool_)
    eye = np.linalg.svd(matrix)[2][-1]
    towards = eye[:3] / eye[3] - target.points
    cosine = (towards * target.normals).sum(axis=1) / np.linalg.norm(towards, axis=1)
    facing: Bools = cosine > _SLANT
    return facing


def _fit(target: Target, points: Floats, pixels: Floats) -> Floats:
    """Projection (3, 4), its third column empty for flat targets."""
    if target.is_flat:
        plane = fit_homography(points[:, :2], pixels)
        return np.stack([plane[:, 0], plane[:, 1], np.zeros(3), plane[:, 2]], axis=1)
    return fit_projection(points, pixels)


def _seen(matrix: Floats, points: Floats) -> Floats:
    shown = points @ matrix[:, :3].T + matrix[:, 3]
    with np.errstate(divide="ignore", invalid="ignore"):  # points beside the camera
        seen: Floats = shown[:, :2] / shown[:, 2:]
    return seen


def _numberings(
    target: Target, lattice: Ints, pixels: Floats, steps: Ints, anchors: Sequence[Anchor]
) -> list[_Way]:
    """List the ways to name the dots that fit."""
    low = lattice.min(axis=0)
    extent = lattice.max(axis=0) - low + 1
    table = np.full(extent, -1, dtype=np.int64)
    table[tuple((lattice - low).T)] = np.arange(len(lattice))
    pitch = _pitch(pixels, steps)
    named = _named(pixels, anchors, pitch)
    wrap = _columns_around(target, lattice)
    ways = []
    for turn in _TURNS:
        turned = steps @ turn.T
        turned = turned - turned.min(axis=0)
        size = turned.max(axis=0) + 1
        columns = range(extent[1]) if wrap else range(1 - size[1], extent[1])
        for row in range(1 - size[0], extent[0]):
            for column in columns:
                places = turned + np.array([row, column])
                ids = _looked_up(table, _wrapped(places, wrap))
                enough = (ids >= 0).sum() >= max(_OVERLAP * len(ids), 6)
                if enough and all(ids[dot] == point for dot, point in named):
                    ways.append(_Way(ids, places + low))
    return [way for way in ways if _fits(target, way.ids, pixels, pitch)]


def _looked_up(table: Ints, places: Ints) -> Ints:
    inside = ((places >= 0) & (places < table.shape)).all(axis=1)
    ids = np.full(len(places), -1, dtype=np.int64)
    ids[inside] = table[tuple(places[inside].T)]
    return ids


def _pitch(pixels: Floats, steps: Ints) -> float:
    """Median distance of dots that are one step apart, px."""
    places = {tuple(step): number for number, step in enumerate(steps.tolist())}
    gaps = [
        float(np.linalg.norm(pixels[number] - pixels[places[place[0] + 1, place[1]]]))
        for place, number in places.items()
        if (place[0] + 1, place[1]) in places
    ]
    return float(np.median(gaps)) if gaps else 1.0


def _named(pixels: Floats, anchors: Sequence[Anchor], pitch: float) -> list[tuple[int, int]]:
    named = []
    for anchor in anchors:
        gaps = np.linalg.norm(pixels - anchor.pixel, axis=1)
        if gaps.min() > pitch / 2:
            x, y = anchor.pixel
            raise DataError(f"no dot of the lattice near the anchor at ({x:.0f}, {y:.0f}) px")
        named.append((int(np.argmin(gaps)), anchor.point))
    return named


def _fits(target: Target, ids: Ints, pixels: Floats, pitch: float) -> bool:
    """Say whether a numbering is seen as a pinhole sees it, from the front."""
    seen = ids >= 0
    points, at = target.points[ids[seen]], pixels[seen]
    try:
        matrix = _fit(target, points, at)
    except DataError:
        return False
    rest = np.linalg.norm(_seen(matrix, points) - at, axis=1)
    ahead = np.sign(np.median(points @ matrix[2, :3] + matrix[2, 3]))
    hand = np.linalg.det(matrix[:, [0, 1, 3]] if target.is_flat else matrix[:, :3])
    proper = hand * ahead < 0 if target.is_flat else hand * ahead > 0
    return bool(proper and np.median(rest) < _FITS * pitch)
