"""Motion in the middle of a matched subset that its shape function has not followed.

What is left of the grey after a match, near the centre, is looked at as a small shift of
its own: where the field bends more sharply than the shape function can, the centre lies
elsewhere than the whole subset says.
"""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.kernels.subset_noise import load_grey, load_weights, take_residual

_ZERO = np.float32(0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def rest_motion(
    reference: Greys,
    coefficients: Greys,
    wide: int | None,
    inside: Greys,
    other_inside: Greys,
    points: Ints,
    warps: Floats,
    radius: int,
    spread: float,
    shift: Floats,
    doubt: Floats,
    misfit: Floats,
) -> None:
    """Fit a shift to what a match has left near the centre of each subset.

    Parameters
    ----------
    reference, coefficients, wide, inside, other_inside, points, warps
        As in :func:`~shapemorph.kernels.subset_noise.residual_products`.
    radius : int
        Of the part that is looked at, px.
    spread : float
        Standard deviation of its Gaussian weights, px.
    shift : (N, 2)
        Filled with the motion of the reference pattern that is left, px of the reference;
        NaN where there is too little pattern.
    doubt : (N, 3)
        Filled with its variance along x, along y and its covariance, for noise of one.
    misfit : (N, 2)
        Filled with the mean square of what is left, and of the slopes along both axes.
    """
    width = 2 * radius + 1
    weights = np.zeros((width, width), dtype=np.float32)
    found = np.zeros((width, width), dtype=np.float32)
    system = np.zeros((10, 4))
    bell = np.exp(-0.5 * (np.arange(-radius, radius + 1) / spread) ** 2)
    for k in range(points.shape[0]):
        shift[k, 0], shift[k, 1] = np.nan, np.nan
        misfit[k, 0], misfit[k, 1] = np.nan, np.nan
        x, y = points[k, 0], points[k, 1]
        count = load_weights(inside, other_inside, x, y, warps[k], radius, weights)
        if count < 0.5 * width * width:
            continue
        load_grey(coefficients, wide, x, y, warps[k], radius, weights, found)
        take_residual(reference, x, y, radius, weights, found, system)
        xx, xy, yy, rx, ry = 0.0, 0.0, 0.0, 0.0, 0.0
        qxx, qxy, qyy, left, steep = 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(width):
            for i in range(width):
                if weights[j, i] == _ZERO:
                    continue
                weight = bell[j] * bell[i]
                along_x = reference[1, y + j - radius, x + i - radius]
                along_y = reference[2, y + j - radius, x + i - radius]
                rest = found[j, i]
                xx += weight * along_x * along_x
                xy += weight * along_x * along_y
                yy += weight * along_y * along_y
                rx += weight * along_x * rest
                ry += weight * along_y * rest
                qxx += weight * weight * along_x * along_x
                qxy += weight * weight * along_x * along_y
                qyy += weight * weight * along_y * along_y
                left += rest * rest
                steep += along_x * along_x + along_y * along_y
        misfit[k, 0], misfit[k, 1] = left / count, 0.5 * steep / count
        det = xx * yy - xy * xy
        if not det > 0.02 * xx * yy:
            continue
        a, b, c = yy / det, -xy / det, xx / det
        shift[k, 0], shift[k, 1] = a * rx + b * ry, b * rx + c * ry
        doubt[k, 0] = a * a * qxx + 2.0 * a * b * qxy + b * b * qyy
        doubt[k, 1] = b * b * qxx + 2.0 * b * c * qxy + c * c * qyy
        doubt[k, 2] = a * b * qxx + (a * c + b * b) * qxy + b * c * qyy
