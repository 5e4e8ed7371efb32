"""Whether two pictures lie so near each other that subsets find their way without features."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.core.status import PointStatus
from shapemorph.methods.contrast import even_contrast
from shapemorph.methods.laws.identity import identity_warp
from shapemorph.methods.repetition import find_repeat
from shapemorph.methods.spline_pictures import (
    DeformedPicture,
    ReferencePicture,
    prepare_deformed,
    prepare_reference,
)
from shapemorph.methods.subset_dic import (
    SubsetSettings,
    affine_starts,
    grid_points,
    match_points,
)
from shapemorph.methods.threads import run_at_once
from shapemorph.methods.warping import warp_points

POINTS = 200  # that are tried, about
LEAST_POINTS = 12  # with a pattern: fewer prove nothing
SHARE = 0.85  # of the tried points that must find their match
TILE, TILES, LEAST_TILE = 192, 4, 48  # px wide, along each side, px
COVERED = 0.7  # share of a tile that must lie inside the mask
LEAST_ALIKE = 6  # tiles whose shifts agree
ROUNDS, TRIMMED = 4, 3.0  # of the affine fit; times the median residual
MIDDLE = 1024  # px of the picture that are looked at for repeats
STD_PER_WIDTH, WINDOW = 0.42, 12.0  # standard deviation of a speckle; of which contrast is evened
NO_PATTERN = (PointStatus.LOW_CONTRAST, PointStatus.LEFT_IMAGE, PointStatus.OUTSIDE_MASK)


@dataclass(frozen=True, slots=True, eq=False)
class NearStart:
    """Where subsets of one picture begin to look for their matches in another.

    Attributes
    ----------
    warp : Warp
        Reference -> deformed.
    source : ReferencePicture
    target : DeformedPicture
        The two pictures, padded for subsets of the size that was tried.
    """

    warp: Warp
    source: ReferencePicture
    target: DeformedPicture


def near_start(
    reference: GreyImage,
    deformed: GreyImage,
    *,
    speckle: Callable[[], float],
    settings: SubsetSettings,
    min_zncc: float,
) -> NearStart | None:
    """Find an affine warp from which nearly all of some sample subsets match.

    First no motion is tried, then a map through the shifts of large tiles. Of a pattern
    that repeats nothing is believed: a match could be off by a repeat.

    Parameters
    ----------
    reference, deformed : GreyImage
    speckle : callable
        Measures the size of a speckle of the reference, px; NaN if it is not known.
    settings : SubsetSettings
        As for the correlation.
    min_zncc : float
        Least correlation of a match.

    Returns
    -------
    NearStart or None
        None where features have to be matched.
    """

    def repeats() -> bool:
        size = speckle()
        return bool(np.isfinite(size)) and _repeats(reference, size)

    def tried() -> NearStart | None:
        return _tried_start(reference, deformed, settings, min_zncc)

    asked: tuple[Callable[[], NearStart | bool | None], ...] = (tried, repeats)
    start, repeat = run_at_once(lambda ask: ask(), asked)
    return start if isinstance(start, NearStart) and not repeat else None


def _tried_start(
    reference: GreyImage, deformed: GreyImage, settings: SubsetSettings, min_zncc: float
) -> NearStart | None:
    """Start from no motion, else from the shifts of tiles; None where neither leads on."""
    start = start_from(identity_warp(reference.shape), reference, deformed, settings=settings)
    pictures = start.source, start.target, reference.mask
    still = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    found = _leads(*pictures, still, settings, min_zncc)
    if found is None and (rough := _tile_shifts(reference, deformed)) is not None:
        found = _leads(*pictures, rough, settings, min_zncc)
    return None if found is None else replace(start, warp=_affine_warp(found, reference.shape))


def start_from(
    warp: Warp, reference: GreyImage, deformed: GreyImage, *, settings: SubsetSettings
) -> NearStart:
    """Begin where a warp says."""
    pad, degree = settings.pad, settings.degree
    source = prepare_reference(reference, allowed=None, pad=pad, degree=degree)
    return NearStart(warp, source, prepare_deformed(deformed, pad=pad, degree=degree))


def likeliest_start(
    start: NearStart,
    warps: Sequence[Warp],
    mask: Bools,
    *,
    settings: SubsetSettings,
    min_zncc: float,
) -> NearStart:
    """Begin where that of several warps says from which most of some sample subsets match.

    Parameters
    ----------
    start : NearStart
        Its pictures count.
    warps : sequence of Warp
        The first of equal ones is taken.
    mask : (H, W) bool
        Part of the reference that counts.
    settings, min_zncc
        As for :func:`near_start`.
    """
    if len(warps) == 1:
        return replace(start, warp=warps[0])
    grid = grid_points(mask, spacing=max(1, round(float(np.sqrt(mask.sum() / POINTS)))))
    points = grid.points[grid.inside]
    found = []
    for warp in warps:
        targets, gradient = warp_points(warp, points.astype(np.float64))
        starts = affine_starts(points, targets, gradient)
        tried = match_points(start.source, start.target, points, starts, settings=settings)
        found.append(int(((tried.status == PointStatus.OK) & (tried.zncc >= min_zncc)).sum()))
    return replace(start, warp=warps[int(np.argmax(found))])


def _tile_shifts(reference: GreyImage, deformed: GreyImage) -> Floats | None:
    """Affine map (2, 3) through the shifts of large tiles, by phase correlation."""
    import cv2

    size = min(TILE, min(reference.shape) // 2, min(deformed.shape) // 2)
    height, width = np.minimum(reference.shape, deformed.shape)
    if size < LEAST_TILE:
        return None
    hann = cv2.createHanningWindow((size, size), cv2.CV_64F)
    centres, shifts = [], []
    for row in np.linspace(0, height - size, TILES).astype(int):
        for col in np.linspace(0, width - size, TILES).astype(int):
            tile = np.s_[row : row + size, col : col + size]
            if reference.mask[tile].mean() < COVERED:
                continue
            still, moved = (image.grey[tile].astype(np.float64) for image in (reference, deformed))
            shift, _ = cv2.phaseCorrelate(still - still.mean(), moved - moved.mean(), hann)
            centres.append([col + (size - 1) / 2, row + (size - 1) / 2])
            shifts.append(shift)
    if not centres:
        return None
    middle = np.median(shifts, axis=0)
    alike = np.abs(np.array(shifts) - middle).max(axis=1) < size / 8
    if alike.sum() < LEAST_ALIKE:
        return None
    return _fit_affine(np.array(centres)[alike], (np.array(centres) + shifts)[alike])


def _repeats(picture: GreyImage, speckle: float) -> bool:
    """Whether the middle of a picture looks like itself some way off."""
    corner = [max(0, (size - MIDDLE) // 2) for size in picture.shape]
    middle = np.s_[corner[0] : corner[0] + MIDDLE, corner[1] : corner[1] + MIDDLE]
    part = GreyImage(picture.grey[middle], picture.mask[middle])
    std = speckle * STD_PER_WIDTH
    pattern = even_contrast(part, window=max(3, round(WINDOW * std)))
    return find_repeat(pattern, std=std) is not None


def _leads(
    source: ReferencePicture,
    target: DeformedPicture,
    mask: Bools,
    affine: Floats,
    settings: SubsetSettings,
    min_zncc: float,
) -> Floats | None:
    """Affine map (2, 3) through what sample subsets find from another; None if few do."""
    step = max(1, round(float(np.sqrt(mask.sum() / POINTS))))
    grid = grid_points(mask, spacing=step)
    points = grid.points[grid.inside]
    if len(points) < LEAST_POINTS:
        return None
    starts = points @ affine[:, :2].T + affine[:, 2]
    slopes = np.broadcast_to(affine[:, :2], (len(points), 2, 2))
    found = match_points(
        source, target, points, affine_starts(points, starts, slopes), settings=settings
    )
    tried = ~np.isin(found.status, NO_PATTERN)
    good = (found.status == PointStatus.OK) & (found.zncc >= min_zncc)
    if tried.sum() < LEAST_POINTS or good.sum() < SHARE * tried.sum():
        return None
    return _fit_affine(points[good].astype(np.float64), found.position[good])


def _fit_affine(source: Floats, target: Floats) -> Floats:
    """Least squares (2, 3), without what lies far off."""
    terms = np.column_stack([source, np.ones(len(source))])
    kept: Bools = np.ones(len(source), dtype=bool)
    solution: Floats = np.zeros((3, 2))
    for _ in range(ROUNDS):
        solution = np.asarray(np.linalg.lstsq(terms[kept], target[kept], rcond=None)[0])
        off = np.linalg.norm(target - terms @ solution, axis=1)
        kept = off <= TRIMMED * np.median(off) + 1e-9
    return np.ascontiguousarray(solution.T)


def _affine_warp(affine: Floats, shape: tuple[int, int]) -> Warp:
    warp = identity_warp(shape)
    coefficients = warp.coefficients @ affine[:, :2].T + affine[:, 2]
    return Warp(coefficients, warp.origin, warp.spacing)
