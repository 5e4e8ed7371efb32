"""Many even pairs from few: every point of a grid is searched through the warp so far."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys
from shapemorph.core.matching import Warp
from shapemorph.kernels.zncc import resample_through, search
from shapemorph.methods.contrast import Pattern
from shapemorph.methods.warping import warp_points


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


def search_grid(
    reference: Pattern,
    deformed: Pattern,
    warp: Warp,
    anchors: Floats,
    *,
    reduction: int,
    step: float,
    reach: float,
    half: int,
    radius: int,
    stride: int,
    least_inside: float,
    least_zncc: float,
) -> GridSeeds:
    """Search the points of a grid in the deformed picture, seen through a warp.

    Parameters
    ----------
    reference, deformed : Pattern
    warp : Warp
        Reference -> deformed, right to within `radius`.
    anchors : (K, 2)
        Known points of the reference picture, px; only near them is the warp trusted.
    reduction : int
        Both pictures are compared at 1 / reduction of their size (coarse speckle).
    step : float
        Distance between grid points, px.
    reach : float
        Farthest that a grid point may lie from the nearest anchor, px.
    half, radius, stride : int
        Window and search, px of the reduced pictures: see
        :func:`shapemorph.kernels.zncc.search`.
    least_inside : float
        Share of a window that must be visible in both pictures.
    least_zncc : float
        Less alike than this is not found.
    """
    height, width = (-(-v // reduction) for v in reference.shape)
    still, still_mask = _reduce(reference, reduction)
    softened = _soften(deformed.values, _stride_px(warp, anchors) * reduction)
    moved, moved_mask = resample_through(
        warp.coefficients, warp.origin, warp.spacing, softened, deformed.mask,
        height, width, 1.0 / reduction,
    )  # fmt: skip
    grid = grid_points(reference.mask, step)
    grid = grid[nearest_distance(anchors, grid) < reach]
    pixels = np.rint((grid + 0.5) / reduction - 0.5).astype(np.int64)
    source = (pixels + 0.5) * reduction - 0.5
    found = search(still, still_mask, moved, moved_mask, pixels, half, radius, stride, least_inside)
    good = found[:, 2] >= least_zncc
    source, shift = source[good], found[good, :2] * reduction
    target, _gradient = warp_points(warp, source + shift)
    inside = np.isfinite(target).all(axis=1)
    return GridSeeds(
        source[inside], shift[inside], target[inside], found[good, 2][inside], len(grid)
    )


def error_of_warp(warp: Warp, source: Floats, target: Floats) -> Floats:
    """(N, 2) shift in the source picture that would make the warp meet the targets, px."""
    predicted, gradient = warp_points(warp, source)
    shift: Floats = np.linalg.solve(gradient, (target - predicted)[..., None])[..., 0]
    return shift


def grid_points(mask: Bools, step: float) -> Floats:
    """(N, 2) points of a regular grid, centred on the picture, on the mask."""
    axes = []
    for size in mask.shape[::-1]:
        count = max(1, int(size // step))
        axes.append((np.arange(count) - (count - 1) / 2) * step + (size - 1) / 2)
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    pixels = np.rint(points).astype(np.int64)
    chosen: Floats = points[mask[pixels[:, 1], pixels[:, 0]]]
    return chosen


def nearest_distance(anchors: Floats, points: Floats) -> Floats:
    """(N,) distance of each point from the nearest anchor."""
    from scipy.spatial import cKDTree

    distance, _index = cKDTree(anchors).query(points)
    return np.asarray(distance, np.float64)


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


def _stride_px(warp: Warp, anchors: Floats) -> float:
    """Median length in the deformed picture of one px of the reference."""
    _targets, gradient = warp_points(warp, anchors)
    return float(np.sqrt(np.median(np.abs(np.linalg.det(gradient)))))


def _soften(values: Greys, stride: float) -> Greys:
    """Blur a picture that is about to be sampled at a wider stride than its pixels."""
    import cv2

    if stride < 1.5:
        return values
    blurred: Greys = cv2.GaussianBlur(values, (0, 0), 0.35 * stride)
    return blurred
