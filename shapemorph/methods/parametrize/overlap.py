"""How much of a flattening lies on top of itself."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.kernels.raster import rasterise

SAMPLES = 400_000  # pixels of the test picture


def overlap_share(plane: Floats, faces: Ints) -> float:
    """Share of the covered area of the plane that more than one triangle covers.

    Parameters
    ----------
    plane : (V, 2)
        x right, y up; triangles that lie upside down do not count.
    faces : (F, 3)
    """
    low, extent = plane.min(axis=0), np.ptp(plane, axis=0)
    step = np.sqrt(max(float(extent.prod()), 1e-300) / SAMPLES)
    width, height = (np.ceil(extent / step) + 1).astype(int)
    triangle, _, overlaps = rasterise((plane - low) / step, faces, 1.0, int(height), int(width))
    covered = int((triangle >= 0).sum())
    return overlaps / covered if covered else 1.0
