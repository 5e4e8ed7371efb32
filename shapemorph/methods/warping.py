"""Evaluate smooth warps."""

from shapemorph.core.arrays import Floats
from shapemorph.core.matching import Warp
from shapemorph.methods.spline_sampling import sample_vectors


def warp_points(warp: Warp, points: Floats) -> tuple[Floats, Floats]:
    """Carry points through a warp.

    Parameters
    ----------
    warp : Warp
    points : (N, 2)
        Positions in the source picture, px.

    Returns
    -------
    targets : (N, 2)
        Positions in the target picture, px; NaN outside the warp's own extent.
    gradient : (N, 2, 2)
        d target[i] / d source[j]; NaN likewise.
    """
    in_grid = (points - warp.origin) / warp.spacing
    targets, gradient = sample_vectors(warp.coefficients, in_grid)
    return targets, gradient / warp.spacing
