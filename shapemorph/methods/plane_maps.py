"""Linear maps of the plane, many at a time."""

import numpy as np

from shapemorph.core.arrays import Floats


def inverse_maps(maps: Floats) -> Floats:
    """Invert maps (N, 2, 2); NaN or infinite where one has collapsed."""
    (a, b), (c, d) = np.moveaxis(maps, 0, -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.moveaxis(np.array([[d, -b], [-c, a]]) / (a * d - b * c), -1, 0))
