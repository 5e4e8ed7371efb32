"""Which features look alike: mutual nearest neighbours that are clearly the best."""

import numpy as np

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.kernels.nearest import improve_columns, two_best
from shapemorph.methods.features import Features
from shapemorph.methods.threads import run_blocks

BLOCK = 2048
COLUMNS = 1024
ROWS = 512


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
    back, back_best = np.zeros(len(deformed), np.int64), np.full(len(deformed), -1.0, np.float32)
    columns = np.ascontiguousarray(deformed.descriptors.T)
    for start in range(0, count, BLOCK):
        part = slice(start, min(start + BLOCK, count))
        likeness = _product(reference.descriptors[part], columns)
        improve_columns(likeness, start, back, back_best, COLUMNS)
        two_best(likeness, deformed.points, apart, nearest[part], best[part], second[part])
    good = back[nearest] == np.arange(count)
    near = _distance(best, reference.descriptors, deformed.descriptors[nearest])
    far = _distance(second, reference.descriptors, deformed.descriptors[nearest])
    good &= near < ratio * far
    chosen = np.flatnonzero(good)
    return chosen, nearest[chosen]


def _product(rows: Greys, columns: Greys) -> Greys:
    """Inner products of rows (R, D) and columns (D, C), on all threads."""
    product = np.empty((len(rows), columns.shape[1]), np.float32)

    def multiply(first: int, last: int) -> None:
        np.matmul(rows[first:last], columns, out=product[first:last])

    run_blocks(multiply, len(rows), block=ROWS)
    return product


def _distance(product: Greys, left: Greys, right: Greys) -> Floats:
    """Euclidean distance from inner products, in double precision."""
    lengths = (left.astype(np.float64) ** 2).sum(1) + (right.astype(np.float64) ** 2).sum(1)
    distance: Floats = np.sqrt(np.maximum(lengths - 2.0 * product, 0.0))
    return distance
