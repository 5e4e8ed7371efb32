"""A warp and its inverse undo each other."""

import numpy as np

from shapemorph.methods.warp_fit import fit_warp
from shapemorph.methods.warp_inverse import inverse_warp
from shapemorph.methods.warping import warp_points

SHAPE, BIG = (120, 170), (190, 230)


def _move(points):
    x, y = points.T
    return np.stack([1.3 * x + 0.2 * y + 4 * np.sin(y / 25), 9 - 0.1 * x + 1.2 * y], axis=1) + 12


def test_there_and_back_is_where_it_was():
    columns, rows = np.meshgrid(np.arange(-20.0, 195, 5), np.arange(-20.0, 145, 5))
    grid = np.stack([columns, rows], axis=-1).reshape(-1, 2)
    extent = (np.full(2, -20.0), np.array(SHAPE[::-1]) + 20.0)
    warp = fit_warp(grid, _move(grid), extent=extent, spacing=12.0, smoothing=1e-7)
    mask = np.zeros(SHAPE, bool)
    mask[5:110, 10:165] = True
    back = inverse_warp(warp, mask, BIG)
    inner = grid[(grid > [12, 8]).all(axis=1) & (grid < [160, 106]).all(axis=1)]
    there, _ = warp_points(warp, inner)
    # the map bends over 25 px; splines of 12 px hold it to some hundredths
    assert np.abs(warp_points(back, there)[0] - inner).max() < 0.05
