"""Many even pairs from few: every point of a grid is searched through the warp so far."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys
from shapemorph.core.matching import Warp
from shapemorph.kernels.zncc import resample_through, search
from shapemorph.methods.contrast import Pattern
from shapemorph.methods.speckle_ellipse import mean_covariance
from shapemorph.methods.views import blur_anisotropic
from shapemorph.methods.warping import warp_points

UNLIKE = 0.5  # of the narrower speckle's covariance: a smaller difference is left alone


@dataclass(frozen=True, slots=True, eq=False)
class GridSeeds:
    """Grid points that were found again.

    Attributes
    ----------
    source : (N, 2) float64
        Position in the reference picture, px.
    shift : (N, 2) float64
        How far from it, in the frame of the reference, the warped deformed picture shows
        the same, px: the error of the warp.
    target : (N, 2) float64
        Position in the deformed picture, px.
    zncc : (N,) float64
    asked : int
        Grid points that were searched.
    """

    source: Floats
    shift: Floats
    target: Floats
    zncc: Floats
    asked: int


@dataclass(frozen=True, slots=True, kw_only=True)
class GridSearch:
    """How a grid is searched.

    Attributes
    ----------
    step : float
        Distance between grid points, px of the reference.
    reach : float
        Farthest that a grid point may lie from the nearest known point, px; beyond it the
        warp is not trusted.
    reduction : int
        Both pictures are compared at 1 / reduction of their size (coarse speckle).
    half, radius, stride : int
        Window and search, px of the reduced pictures: see
        :func:`shapemorph.kernels.zncc.search`.
    least_inside : float
        Share of a window that must be visible in both pictures.
    least_zncc : float
        Less alike than this is not found.
    """

    step: float
    reach: float
    reduction: int
    half: int
    radius: int
    stride: int
    least_inside: float
    least_zncc: float


def search_grid(
    reference: Pattern, deformed: Pattern, warp: Warp, known: Floats, how: GridSearch
) -> GridSeeds:
    """Search the points of a grid in the deformed picture, seen through a warp.

    Parameters
    ----------
    reference, deformed : Pattern
    warp : Warp
        Reference -> deformed, right to within the radius of the search.
    known : (K, 2)
        Points of the reference picture at which the warp is right, px.
    how : GridSearch
    """
    grid = grid_points(reference.mask, how.step)
    grid = grid[nearest_distance(known, grid) < how.reach]
    pixels = np.rint((grid + 0.5) / how.reduction - 0.5).astype(np.int64)
    still, still_mask = _reduce(reference, how.reduction)
    softened = _soften(deformed.values, _stride_px(warp, known) * how.reduction)
    moved, moved_mask = resample_through(
        warp.coefficients, warp.origin, warp.spacing, softened, deformed.mask,
        *still.shape, 1.0 / how.reduction,
    )  # fmt: skip
    still, moved = _equally_soft(still, moved, (still_mask > 0) & (moved_mask > 0))
    found = search(
        still, still_mask, moved, moved_mask, pixels,
        how.half, how.radius, how.stride, how.least_inside,
    )  # fmt: skip
    source = ((pixels + 0.5) * how.reduction - 0.5).astype(np.float64)
    target, _gradient = warp_points(warp, source + found[:, :2] * how.reduction)
    good = (found[:, 2] >= how.least_zncc) & on_mask(deformed.mask, target)
    shift = found[good, :2] * how.reduction
    return GridSeeds(source[good], shift, target[good], found[good, 2], len(grid))


def error_of_warp(warp: Warp, source: Floats, target: Floats) -> Floats:
    """(N, 2) shift in the source picture that would make the warp meet the targets, px."""
    predicted, gradient = warp_points(warp, source)
    shift = np.linalg.solve(gradient, (target - predicted)[..., None])[..., 0]
    return np.asarray(shift, np.float64)


def grid_points(mask: Bools, step: float) -> Floats:
    """(N, 2) points of a regular grid, centred on the picture, on the mask."""
    axes = []
    for size in mask.shape[::-1]:
        count = max(1, int(size // step))
        axes.append((np.arange(count) - (count - 1) / 2) * step + (size - 1) / 2)
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2).astype(np.float64)
    chosen: Floats = points[on_mask(mask, points)]
    return chosen


def nearest_distance(known: Floats, points: Floats) -> Floats:
    """(N,) distance of each point from the nearest anchor."""
    from scipy.spatial import cKDTree

    distance, _index = cKDTree(known).query(points)
    return np.asarray(distance, np.float64)


def on_mask(mask: Bools, points: Floats) -> Bools:
    """(N,) whether the pixel under each point is on the mask; NaN is not."""
    height, width = mask.shape
    col, row = np.rint(np.nan_to_num(points, nan=-1.0)).astype(np.int64).T
    inside: Bools = (col >= 0) & (row >= 0) & (col < width) & (row < height)
    inside[inside] = mask[row[inside], col[inside]]
    return inside


def _reduce(pattern: Pattern, factor: int) -> tuple[Greys, Greys]:
    """Block means of a pattern, and where all of the block is inside."""
    height, width = (-(-v // factor) for v in pattern.shape)
    values = np.zeros((height * factor, width * factor), np.float32)
    inside = np.zeros_like(values)
    values[: pattern.shape[0], : pattern.shape[1]] = pattern.values
    inside[: pattern.shape[0], : pattern.shape[1]] = pattern.mask
    blocks = (height, factor, width, factor)
    whole = (inside.reshape(blocks).min(axis=(1, 3)) > 0).astype(np.float32)
    return values.reshape(blocks).mean(axis=(1, 3)).astype(np.float32) * whole, whole


def _stride_px(warp: Warp, known: Floats) -> float:
    """Median length in the deformed picture of one px of the reference."""
    _targets, gradient = warp_points(warp, known)
    covered = gradient[np.isfinite(gradient).all(axis=(1, 2))]
    return float(np.sqrt(np.median(np.abs(np.linalg.det(covered))))) if len(covered) else 1.0


def _equally_soft(still: Greys, moved: Greys, seen: Bools) -> tuple[Greys, Greys]:
    """Blur, along each direction, the sharper of two pictures like the softer.

    What they show is alike, so that a speckle that is wider in one of them is out of focus
    there, or was seen from farther away.
    """
    ours, theirs = mean_covariance(still, seen), mean_covariance(moved, seen)
    if ours is None or theirs is None:
        return still, moved
    eigenvalues, axes = np.linalg.eigh(theirs - ours)
    least = UNLIKE * min(np.linalg.eigvalsh(ours)[0], np.linalg.eigvalsh(theirs)[0])
    both = []
    for values, sign in ((still, 1.0), (moved, -1.0)):
        missing = np.where(sign * eigenvalues > least, sign * eigenvalues, 0.0)
        both.append(np.asarray(blur_anisotropic(values, (axes * missing) @ axes.T), np.float32))
    return both[0], both[1]


def _soften(values: Greys, stride: float) -> Greys:
    """Blur a picture that is about to be sampled at a wider stride than its pixels."""
    import cv2

    if stride < 1.5:
        return values
    blurred: Greys = cv2.GaussianBlur(values, (0, 0), 0.35 * stride)
    return blurred
