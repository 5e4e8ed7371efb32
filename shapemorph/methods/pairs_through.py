"""Pairs of features found by looking at one picture through a rough warp."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.matching import Warp
from shapemorph.kernels.zncc import resample_through
from shapemorph.methods.contrast import Pattern
from shapemorph.methods.features import Features
from shapemorph.methods.first_pairs import (
    CELL,
    Budget,
    FirstPairs,
    Side,
    pair_features,
    side_features,
)
from shapemorph.methods.warp_fit import fit_warp
from shapemorph.methods.warping import warp_points

PER_CELL = (6.0, 9.6)
MOST_FEATURES = (6000, 9600)
REACH = 3.0  # gaps between known pairs that a warp is trusted for


def warp_through(side: Side, source: Floats, target: Floats) -> tuple[Warp, float]:
    """Fit a warp of the whole picture through a few pairs; also how far from them it holds.

    Parameters
    ----------
    side : Side
        The reference.
    source, target : (N, 2)
        Pairs that agree with each other, px; at least 3, not in one line.

    Returns
    -------
    warp : Warp
    reach : float
        Distance from the nearest pair, px of the reference.
    """
    gap = float(np.sqrt(side.pattern.mask.sum() / len(source)))
    spacing = max(CELL * side.std, 2 * gap)
    high = np.array(side.pattern.shape[::-1]) - 1.0
    warp = fit_warp(
        source,
        target,
        extent=(-np.full(2, spacing), high + spacing),
        spacing=spacing,
        smoothing=None,
    )
    return warp, REACH * max(gap, CELL * side.std)


def pairs_through(
    left: Side, right: Side, warp: Warp, *, ratio: float, known: Floats | None, reach: float
) -> tuple[tuple[Features, Features], FirstPairs]:
    """Find pairs where a warp has made the deformed picture look like the reference.

    The warp may be off by any rotation and by some stretch: it only has to take away
    what features are not used to.

    Parameters
    ----------
    left, right : Side
    warp : Warp
        Reference -> deformed.
    ratio : float
        Largest allowed distance of the best descriptor over that of the second best.
    known : (K, 2) or None
        Points of the reference at which the warp is right, px; None: everywhere.
    reach : float
        Farthest from these that it is used, px.

    Returns
    -------
    features : tuple of Features
        Of both pictures.
    pairs : FirstPairs
    """
    height, width = left.pattern.shape
    values, seen = resample_through(
        warp.coefficients, warp.origin, warp.spacing,
        right.pattern.values, right.pattern.mask, height, width, 1.0,
    )  # fmt: skip
    mask = seen > 0
    if known is not None:
        mask &= _near(known, left.pattern.shape, reach)
    moved = Side(Pattern(values, mask, right.pattern.contrast), left.speckle)
    budgets = [Budget(each, most) for each, most in zip(PER_CELL, MOST_FEATURES, strict=True)]
    with ThreadPoolExecutor(2) as pool:
        ours, theirs = pool.map(side_features, (left, moved), budgets)
    theirs = _carried(theirs, warp)
    return (ours, theirs), pair_features(ours, theirs, std=right.std, ratio=ratio)


def _near(known: Floats, shape: tuple[int, int], reach: float) -> Bools:
    """(H, W) pixels within reach of a known point."""
    import cv2

    far = np.ones(shape, np.uint8)
    cols, rows = np.rint(known).astype(np.int64).T
    inside = (cols >= 0) & (rows >= 0) & (cols < shape[1]) & (rows < shape[0])
    far[rows[inside], cols[inside]] = 0
    near: Bools = np.asarray(cv2.distanceTransform(far, cv2.DIST_L2, 5) <= reach)
    return near


def _carried(features: Features, warp: Warp) -> Features:
    """Features that were seen through a warp, where they are in the picture behind it."""
    points, gradient = warp_points(warp, features.points)
    return replace(features, points=points, frames=gradient @ features.frames)
