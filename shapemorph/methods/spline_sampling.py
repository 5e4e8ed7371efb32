"""Vector-valued splines at many points, by several threads."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.kernels.bspline import fill_vectors
from shapemorph.methods.threads import run_blocks

BLOCK = 4096  # points that a thread takes at once


def sample_vectors(coefficients: Floats, points: Floats) -> tuple[Floats, Floats]:
    """Evaluate a vector-valued spline and its derivatives at scattered points.

    Parameters
    ----------
    coefficients : (H, W, D)
        Control grid.
    points : (N, 2)
        Positions (x, y) in units of the grid.

    Returns
    -------
    values : (N, D)
        NaN where the 4 x 4 support leaves the grid.
    gradients : (N, D, 2)
        Derivatives with respect to x and y in units of the grid; NaN likewise.
    """
    control, at = np.ascontiguousarray(coefficients), np.ascontiguousarray(points)
    values = np.empty((len(at), control.shape[2]))
    gradients = np.empty((*values.shape, 2))

    def work(first: int, last: int) -> None:
        some = slice(first, last)
        fill_vectors(control, at[some], values[some], gradients[some])

    run_blocks(work, len(at), block=BLOCK)
    return values, gradients
