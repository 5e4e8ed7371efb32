"""What rigid motions leave between two sets of points."""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats


@njit(cache=True, nogil=True)
def clipped_misfits(
    source: Floats, target: Floats, rotations: Floats, translations: Floats, most: float
) -> Floats:
    """Sum the squared distances that each motion leaves, none counting more than `most`.

    Parameters
    ----------
    source, target : (N, 3)
        Paired points.
    rotations : (H, 3, 3)
    translations : (H, 3)
    most : float
        Square of a length.

    Returns
    -------
    (H,)
    """
    found = np.zeros(len(rotations))
    for h in range(len(rotations)):
        turn, shift = rotations[h], translations[h]
        for n in range(len(source)):
            squared = 0.0
            for d in range(3):
                along = turn[d, 0] * source[n, 0] + turn[d, 1] * source[n, 1]
                along += turn[d, 2] * source[n, 2] + shift[d] - target[n, d]
                squared += along * along
            found[h] += min(squared, most)
    return found
