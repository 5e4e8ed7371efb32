"""Grid spacing for a flattening that does not show all of the surface at one scale."""

import numpy as np

from shapemorph.core.flattened import Distortion
from shapemorph.methods.distortion import local_scale, weighted_quantile

SMALL_SHARE = 0.05  # of the surface may be shown smaller than what is looked at
ALLOWED = 1.25  # times the usual distance on the surface that points there may be apart
FINEST = 0.5  # of the spacing that the subset asks for


def even_spacing(spacing: int, distortion: Distortion) -> int:
    """Make a spacing finer where a part of the surface is shown much smaller than the rest.

    Points lie on a regular grid of the picture, so they are far apart on what the picture
    shows small.

    Parameters
    ----------
    spacing : int
        That suits the subset, px.
    distortion : Distortion
        Of the reference.

    Returns
    -------
    int
        px; at least half of `spacing`.
    """
    scale = local_scale(distortion)
    small, median = (
        weighted_quantile(scale, distortion.area, share) for share in (SMALL_SHARE, 0.5)
    )
    if not median > 0:
        return spacing
    return max(1, round(spacing * float(np.clip(ALLOWED * small / median, FINEST, 1.0))))
