"""Where the middle of the picture of a round dot lies."""

import numpy as np

from shapemorph.core.arrays import Floats


def middle_of_dots(centres: Floats, normals: Floats, radius: Floats) -> Floats:
    """Find the centres of the ellipses as which round dots are seen.

    A circle with centre c, unit normal n and radius r, in the frame of the camera, is seen as
    the conic whose dual is r² (I - n nᵀ) - c cᵀ; its pole of the line at infinity is the
    centre of the ellipse. It differs from the picture of c where the dot is tilted.

    Parameters
    ----------
    centres, normals : (N, 3)
        In the frame of the camera, mm.
    radius : (N,)
        mm.

    Returns
    -------
    (N, 2)
        Directions with z = 1; NaN behind the camera.

    References
    ----------
    .. [1] Heikkilä, J. (2000). IEEE TPAMI 22, 1066-1077. :doi:`10.1109/34.879788`
    """
    square = (radius**2)[:, None]
    depth, tilt = centres[:, 2:], normals[:, 2:]
    below = depth**2 - square * (1 - tilt**2)
    above = centres[:, :2] * depth + square * normals[:, :2] * tilt
    return np.where(depth > 0, above, np.nan) / np.where(below > 0, below, np.nan)
