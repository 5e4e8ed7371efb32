"""Pairs of features from many simulated views of one picture, for any stretch.

Where the shape of the speckle does not tell the stretch, it is guessed: the deformed
picture is compressed along many directions by several ratios, and each of these views is
matched with the reference. What is found serves as a rough warp, through which the
pictures are matched again.
"""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.methods.consistency import consistent_pairs
from shapemorph.methods.densify import nearest_distance
from shapemorph.methods.features import Features, detect_features
from shapemorph.methods.first_pairs import NEIGHBOURS, SUPPORT, FirstPairs, Side, voted_pairs
from shapemorph.methods.pairs_through import pairs_through, warp_through
from shapemorph.methods.views import view_of

TILTS = ((1.0, 1), (1.6, 4), (2.5, 7), (4.0, 11), (6.3, 16))  # ratio, directions
VIEW_STD = 1.5  # px that the speckle gets in a view ...
LARGEST_VIEW = 2.5e5  # px; ... if this allows for it
FEATURES, PER_CELL = (1500, 2000), 4  # of the reference, of each view
COVERED = 0.7  # share of the reference's features near a pair, with which no more is tried
NEAR = 3.0  # cells of features
ROUNDS = 3  # of matching through the warp so far
GROWTH = 1.2  # of the number of pairs, that makes another round worth while


def simulated_pairs(
    left: Side, right: Side, *, ratio: float
) -> tuple[tuple[Features, Features], FirstPairs]:
    """Find pairs of features, whatever the stretch: views of the deformed picture are simulated.

    Parameters
    ----------
    left, right : Side
    ratio : float
        Largest allowed distance of the best descriptor over that of the second best.

    Returns
    -------
    features : tuple of Features
        Of the two pictures, as they were seen last.
    pairs : FirstPairs

    References
    ----------
    J.-M. Morel, G. Yu, "ASIFT: a new framework for fully affine invariant image comparison",
    SIAM J. Imaging Sciences 2 (2009), doi:10.1137/080732730.
    """
    features, pairs = _bank(left, right, ratio)
    for _ in range(ROUNDS):
        if len(pairs) <= NEIGHBOURS[1] // 2:
            break
        try:
            warp, reach = warp_through(left, pairs.source, pairs.target)
        except DataError:  # all in one line
            break
        again, better = pairs_through(
            left, right, warp, ratio=ratio, known=pairs.source, reach=reach
        )
        growth = len(better) / len(pairs)
        if growth > 1:
            features, pairs = again, better
        if growth < GROWTH:
            break
    return features, pairs


def _bank(left: Side, right: Side, ratio: float) -> tuple[tuple[Features, Features], FirstPairs]:
    """Match all views and keep, of every feature of the reference, the pair best supported."""
    ours, cell = _seen(left, np.eye(2), FEATURES[0])
    target, support = np.zeros((len(ours), 2)), np.zeros(len(ours))
    alike, upright, counts = 0, ours, {"features_reference": len(ours), "views": 0}
    for level, (tilt, directions) in enumerate(TILTS):
        with ThreadPoolExecutor(2) as pool:
            views = pool.map(lambda m: _seen(right, m, FEATURES[1])[0], _matrices(tilt, directions))
            for theirs in views:
                found = voted_pairs(ours, theirs, std=right.std, ratio=ratio)
                better = found.support > support[found.i]
                i, j = found.i[better], found.j[better]
                target[i], support[i] = theirs.points[j], found.support[better]
                alike += len(found.i)
                counts["views"] += 1
                upright = theirs if level == 0 else upright
        good = support >= SUPPORT
        if good.any():
            near = nearest_distance(ours.points[good], ours.points) < NEAR * cell
            if near.mean() > COVERED:
                break
    source, target = ours.points[good], target[good]
    counts |= {"matched": alike, "voted": len(source)}
    kept = consistent_pairs(
        source, target, neighbours=NEIGHBOURS[1], tolerance=2 * right.std, cap=6 * right.std
    )
    counts["consistent"] = int(kept.sum())
    both = np.stack([source, target], axis=1)
    return (ours, upright), FirstPairs(source[kept], target[kept], counts, both)


def _matrices(tilt: float, directions: int) -> Iterator[Floats]:
    """(2, 2) maps of unit area that compress along one of some directions."""
    for number in range(directions):
        angle = np.pi * number / directions
        axes = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        yield axes @ np.diag([tilt**-0.5, tilt**0.5]) @ axes.T


def _seen(side: Side, matrix: Floats, most: int) -> tuple[Features, float]:
    """Features of a picture through a linear map, and the width of their cells, px."""
    area = float(side.pattern.mask.sum())
    cell = float(np.sqrt(area * PER_CELL / most))
    scale = min(1.0, VIEW_STD / side.narrowest, np.sqrt(LARGEST_VIEW / area))
    corner = np.array(side.pattern.shape[::-1]) - 1.0
    view = view_of(side.pattern, scale * matrix, (np.zeros(2), corner), 0.0)
    views = [] if view is None else [view]
    return detect_features(views, contrast=0.02, cell=cell, per_cell=PER_CELL), cell
