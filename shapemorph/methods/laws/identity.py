"""The law that nothing is deformed."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.matching import Warp


def identity_warp(shape: tuple[int, int]) -> Warp:
    """Warp that leaves every point of a picture, and some room around it, where it is."""
    height, width = shape
    spacing = float(max(height, width, 16))
    origin = np.full(2, -2.0 * spacing)
    steps = np.arange(6.0)  # from -2 to 3 spacings; valid from -1 to 2
    cols, rows = np.meshgrid(steps, steps)
    return Warp(np.stack([cols, rows], axis=-1) * spacing + origin, origin, spacing)


def rigid_warp(shape: tuple[int, int], source: Floats, target: Floats, *, scale: float) -> Warp:
    """Warp that turns and shifts a picture, at a given scale, as pairs of points say.

    Parameters
    ----------
    shape : (int, int)
        Height and width of the reference picture.
    source, target : (N, 2)
        Pairs that settle the turn and the shift, px; with fewer than two, there is none.
    scale : float
        px of the deformed picture per px of the reference, of what is not deformed.
    """
    warp = identity_warp(shape)
    turn, shift = _pose(source, target, scale)
    return Warp(warp.coefficients @ (scale * turn).T + shift, warp.origin, warp.spacing)


def _pose(source: Floats, target: Floats, scale: float) -> tuple[Floats, Floats]:
    """(2, 2) rotation and (2,) shift of least squares, after scaling."""
    if len(source) < 2:
        return np.eye(2), np.zeros(2)
    centre, goal = source.mean(axis=0), target.mean(axis=0)
    moment = (source - centre).T @ (target - goal)
    angle = np.arctan2(moment[0, 1] - moment[1, 0], moment[0, 0] + moment[1, 1])
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.array([[cosine, -sine], [sine, cosine]])
    return turn, goal - scale * turn @ centre
