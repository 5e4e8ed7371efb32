"""Subsets that are read again against masks and scipy's spline."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import map_coordinates

from shapemorph.kernels.subset_samples import sample_subsets, weigh_subsets
from shapemorph.kernels.vectors import LANES

RADIUS = 6
WIDTH = 2 * RADIUS + 1
COLUMNS = (WIDTH + 3 + LANES - 1) // LANES * LANES
SHAPE = (64, 96)
WARPS = {
    "in step": [0.4, 1.001, 0.002, 0, 0, 0, -2.6, -0.001, 0.999, 0, 0, 0],
    "stretched": [0.2137, 1.18, -0.12, 0, 0, 0, 3.3071, 0.15, 0.85, 0, 0, 0],
    "bent": [0.3137, 1.02, 0.01, 0.004, -0.003, 0.002, 0.6071, 0.0, 0.99, -0.005, 0.001, 0.004],
}


def _places(at, warp):
    y, x = np.mgrid[-RADIUS : RADIUS + 1, -RADIUS : RADIUS + 1].astype(float)
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    warp = np.array(warp, dtype=float)
    return at[0] + np.tensordot(warp[:6], terms, 1), at[1] + np.tensordot(warp[6:], terms, 1)


def _mask(seed=None):
    mask = np.zeros(SHAPE, dtype=np.float32)
    mask[8:-8, 8 : -8 - LANES] = 1
    if seed is not None:
        mask *= np.random.default_rng(seed).random(SHAPE) > 0.2
    counts = np.zeros((SHAPE[0] + 1, SHAPE[1] + 1), dtype=np.int32)
    counts[1:, 1:] = mask.cumsum(axis=0).cumsum(axis=1)
    return mask, counts


def _read(points, warp, reference, deformed, coefficients, wide=None):
    warps = np.tile(np.array(warp, dtype=float), (len(points), 1))
    weights = np.zeros((len(points), WIDTH, COLUMNS), dtype=np.float32)
    weigh_subsets(*reference, *deformed, points, warps, RADIUS, weights)
    grey = np.full_like(weights, 7.0)
    sample_subsets(coefficients, wide, points, warps, RADIUS, weights, grey)
    return weights, grey


@pytest.mark.parametrize("name", WARPS)
@pytest.mark.parametrize(("wide", "degree"), [(None, 3), (5, 5)])
@pytest.mark.parametrize("seed", [None, 3])
def test_grey_is_that_of_the_spline_where_both_masks_allow(name, wide, degree, seed):
    coefficients = np.random.default_rng(1).random(SHAPE).astype(np.float32)
    points = np.array([[30, 31], [44, 28], [12, 14], [71, 50]])
    reference, deformed = _mask(seed), _mask(None if seed is None else seed + 1)
    weights, grey = _read(points, WARPS[name], reference, deformed, coefficients, wide)
    for k, (x, y) in enumerate(points):
        at_x, at_y = _places((x, y), WARPS[name])
        near = np.floor(at_y + 0.5).astype(int), np.floor(at_x + 0.5).astype(int)
        own = reference[0][y - RADIUS : y + RADIUS + 1, x - RADIUS : x + RADIUS + 1]
        wanted = (own > 0) & (deformed[0][near] > 0)
        assert (weights[k, :, :WIDTH] == wanted).all()
        assert not weights[k, :, WIDTH:].any()
        spline = map_coordinates(
            coefficients.astype(float), [at_y, at_x], order=degree, prefilter=False
        )
        assert_allclose(grey[k, :, :WIDTH], spline * wanted, atol=2e-5)


def test_a_subset_beyond_the_picture_reads_nothing():
    coefficients = np.full(SHAPE, np.nan, dtype=np.float32)
    far = [500.0, 1, 0, 0, 0, 0, -300.0, 0, 1, 0, 0, 0]
    weights, grey = _read(np.array([[40, 30]]), far, _mask(), _mask(), coefficients)
    assert not weights.any()
    assert not grey[:, :, :WIDTH].any()
