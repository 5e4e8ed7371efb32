"""A grid of the middle picture is carried to both originals, exactly or by search."""

import numpy as np
import pytest

from shapemorph.core.image import GreyImage
from shapemorph.methods.coarse_grid import carry_by_search, carry_by_warp, search_middle
from shapemorph.methods.morph_sequence import morph_sequence
from shapemorph.methods.warp_fit import fit_warp

SHIFT = np.array([18.0, -12.0])


@pytest.fixture(scope="module")
def way(wave_pattern, pixel_grid):
    pattern, pixels = wave_pattern(6.0), pixel_grid((150, 180))
    whole = np.ones(pixels.shape[:2], dtype=bool)
    first = GreyImage(pattern(pixels).astype(np.float32), whole)
    second = GreyImage(pattern(pixels - SHIFT).astype(np.float32), whole)
    points = np.random.default_rng(0).uniform(0, 150, (60, 2))

    def through(source, target):
        extent = (np.full(2, -20.0), np.array([200.0, 170.0]))
        return fit_warp(source, target, extent=extent, spacing=30.0, smoothing=1e-4)

    warps = through(points, points + SHIFT), through(points + SHIFT, points)
    pictures = (first, *morph_sequence(first, second, *warps, images=4), second)
    return pictures, warps


@pytest.mark.parametrize("by", ["search", "warp"])
def test_points_end_where_the_material_is(way, by):
    pictures, warps = way
    middle = search_middle(pictures, search=41, subset_size=21, spacing=10, least_zncc=0.8)
    if by == "search":
        carried = carry_by_search(pictures, middle)
    else:
        carried = carry_by_warp(middle, warps, images=4)
    assert len(carried) > 100
    off = carried[:, 1] - carried[:, 0] - SHIFT
    assert np.abs(off).max() < 0.5
