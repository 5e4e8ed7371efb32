"""What subsets make of bending that their shape function does not follow."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys
from shapemorph.methods.matched_subsets import BLOCK, MatchedSubsets

_WORST = 1e-8  # of the largest eigenvalue: pixels that lie in a line say nothing across it
_TERMS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
_FOLLOWED = {0: 1, 1: 3, 2: 6}


def seen_bends(subsets: MatchedSubsets, cut: Bools, *, order: int) -> Floats:
    """Find how far bending moves the positions that subsets give.

    A match is the least-squares fit of the shape function to the true field, over the
    pixels that count in both pictures. A subset that is whole finds a position that is off
    by the mean of x^2 over its pixels, for a field that bends by x^2; one that a rim cuts
    lies to one side of its centre, and by how much it is off depends on what is left of it.

    Parameters
    ----------
    subsets : MatchedSubsets
        Those that were matched with a part of their pixels.
    cut : (R, C) bool
        Which points of a grid they are.
    order : int
        Of the shape function.

    Returns
    -------
    (R, C, 3)
        Position found - true position, for fields that are x^2, x y and y^2 about the
        centre, px^2.

    References
    ----------
    H. W. Schreier, M. A. Sutton, "Systematic errors in digital image correlation due to
    undermatched subset shape functions", Experimental Mechanics 42 (2002),
    doi:10.1007/BF02410987.
    """
    seen = np.zeros((*cut.shape, 3))
    if _FOLLOWED[order] == len(_TERMS):
        return seen
    radius = subsets.radius
    width = 2 * radius + 1
    seen[..., [0, 2]] = (width**2 - 1) / 12.0
    places = np.arange(-radius, radius + 1) / max(radius, 1)
    terms = np.stack([np.outer(places**b, places**a).ravel() for a, b in _TERMS], axis=1)
    found = np.empty((len(subsets.points), 3))
    for first in range(0, len(found), BLOCK):
        last = min(first + BLOCK, len(found))
        weights = subsets.weights(first, last)[:, :, :width].reshape(last - first, -1)
        found[first:last] = _at_centres(weights, terms, _FOLLOWED[order])
    seen[cut] = radius**2 * found
    return seen


def _at_centres(weights: Greys, terms: Floats, followed: int) -> Floats:
    """(N, 3) values at the centre of fits to the terms of second order over some pixels."""
    products = terms[:, :followed, None] * terms[:, None, :]
    sums = (weights @ products.reshape(len(terms), -1)).reshape(-1, followed, len(terms[0]))
    inverse = np.linalg.pinv(sums[:, :, :followed], rcond=_WORST, hermitian=True)
    fitted: Floats = inverse[:, :1] @ sums[:, :, 3:]
    return fitted[:, 0]
