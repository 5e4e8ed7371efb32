"""The way back of a warp."""

import numpy as np

from shapemorph.core.arrays import Bools
from shapemorph.core.matching import Warp
from shapemorph.methods.densify import grid_points
from shapemorph.methods.warp_fit import fit_warp
from shapemorph.methods.warping import warp_points

STIFFNESS = 1e-5  # the pairs have no noise
PER_KNOT = 3  # points per spacing of the warp


def inverse_warp(warp: Warp, mask: Bools, shape: tuple[int, int]) -> Warp:
    """Fit a warp that undoes another one.

    Parameters
    ----------
    warp : Warp
        Source -> target.
    mask : (H, W) bool
        Part of the source picture that counts.
    shape : (int, int)
        Height and width of the target picture.
    """
    step = max(1.0, warp.spacing / PER_KNOT, float(np.sqrt(mask.sum() / 20_000)))
    source = grid_points(mask, step)
    target, gradient = warp_points(warp, source)
    growth = np.sqrt(np.nanmedian(np.abs(np.linalg.det(gradient))))
    spacing = float(max(warp.spacing, 2 * step) * growth)
    high = np.array(shape[::-1]) - 1.0
    extent = (-np.full(2, spacing), high + spacing)
    return fit_warp(target, source, extent=extent, spacing=spacing, smoothing=STIFFNESS)
