"""Values inside triangles from those of their corners."""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats, Ints


@njit(cache=True, nogil=True)
def blend_corners(corner_values: Floats, triangle: Ints, barycentric: Floats) -> Floats:
    """Weigh the values of the corners of the triangle under each point.

    Parameters
    ----------
    corner_values : (M, 3, D)
    triangle : (N,)
        -1 where there is none.
    barycentric : (N, 2)
        Weights of the second and third corner.

    Returns
    -------
    (N, D)
        NaN where there is no triangle.
    """
    count, depth = len(triangle), corner_values.shape[2]
    found = np.empty((count, depth))
    for n in range(count):
        k = triangle[n]
        if k < 0:
            found[n] = np.nan
            continue
        second, third = barycentric[n, 0], barycentric[n, 1]
        for d in range(depth):
            first = corner_values[k, 0, d]
            value = first + second * (corner_values[k, 1, d] - first)
            found[n, d] = value + third * (corner_values[k, 2, d] - first)
    return found
