"""Where a set of points lies, in words."""

import numpy as np

from shapemorph.core.arrays import Floats

_RING = 0.5  # inner over outer radius from which a set is called a ring


def whereabouts(points: Floats) -> str:
    """Describe the place and the extent of some points in half a sentence.

    Parameters
    ----------
    points : (N, 3)
        mm.
    """
    centre = np.median(points, axis=0)
    middle = (np.percentile(points, 1, axis=0) + np.percentile(points, 99, axis=0)) / 2
    distance = np.linalg.norm(points - middle, axis=1)
    inner, outer = np.percentile(distance, [1, 99])
    if inner > _RING * outer:
        return f"a ring around {_triple(middle)} mm between r = {inner:.4g} and {outer:.4g} mm"
    extent = " x ".join(f"{length:.4g}" for length in np.ptp(points, axis=0))
    return f"around {_triple(centre)} mm, extent {extent} mm"


def _triple(values: Floats) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in values) + ")"
