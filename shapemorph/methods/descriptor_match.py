"""Which features look alike: mutual nearest neighbours that are clearly the best."""

import numpy as np

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.methods.features import Features

BLOCK = 2048
WORST = np.float32(-1.0)


def match_descriptors(
    reference: Features, deformed: Features, *, ratio: float, apart: float
) -> tuple[Ints, Ints]:
    """Pair features by their descriptors.

    A pair is kept if each is the other's nearest neighbour and the second best, at
    another place, is clearly farther away in descriptor space. Descriptors are whole
    numbers whose products are exact, so the result does not depend on how the matrix
    product is split.

    Parameters
    ----------
    reference, deformed : Features
    ratio : float
        Largest allowed distance of the best over that of the second best.
    apart : float
        Features of the deformed picture nearer than this to the best one, px, are the
        same place and no competitors.

    Returns
    -------
    i, j : (N,)
        Indices into the two sets.
    """
    if len(reference) == 0 or len(deformed) < 2:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    count = len(reference)
    nearest, best = np.empty(count, np.int64), np.empty(count, np.float32)
    second = np.empty(count, np.float32)
    back, back_best = np.zeros(len(deformed), np.int64), np.full(len(deformed), WORST)
    columns = np.ascontiguousarray(deformed.descriptors.T)
    for start in range(0, count, BLOCK):
        likeness = reference.descriptors[start : start + BLOCK] @ columns
        part = slice(start, start + len(likeness))
        _improve_columns(likeness, start, back, back_best)
        nearest[part], best[part], second[part] = _two_best(likeness, deformed.points, apart)
    good = back[nearest] == np.arange(count)
    near = _distance(best, reference.descriptors, deformed.descriptors[nearest])
    far = _distance(second, reference.descriptors, deformed.descriptors[nearest])
    good &= near < ratio * far
    chosen = np.flatnonzero(good)
    return chosen, nearest[chosen]


def _improve_columns(likeness: Greys, start: int, back: Ints, back_best: Greys) -> None:
    """Update, for every deformed feature, its best reference feature so far."""
    highest = likeness.max(axis=0)
    better = np.flatnonzero(highest > back_best)
    if len(better):
        back[better] = start + likeness[:, better].argmax(axis=0)
        back_best[better] = highest[better]


def _two_best(likeness: Greys, points: Floats, apart: float) -> tuple[Ints, Greys, Greys]:
    """Best column of each row, its likeness, and that of the best at another place."""
    rows = np.arange(len(likeness))
    nearest = likeness.argmax(axis=1)
    best = likeness[rows, nearest]
    likeness[rows, nearest] = WORST
    rival = likeness.argmax(axis=1)
    for _ in range(3):
        same = np.linalg.norm(points[rival] - points[nearest], axis=1) < apart
        if not same.any():
            break
        likeness[rows[same], rival[same]] = WORST
        rival[same] = likeness[same].argmax(axis=1)
    return nearest, best, likeness[rows, rival]


def _distance(product: Greys, left: Greys, right: Greys) -> Floats:
    """Euclidean distance from inner products, in double precision."""
    lengths = (left.astype(np.float64) ** 2).sum(1) + (right.astype(np.float64) ** 2).sum(1)
    return np.sqrt(np.maximum(lengths - 2.0 * product, 0.0))
