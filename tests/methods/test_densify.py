import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.methods.contrast import even_contrast
from shapemorph.methods.densify import (
    GridSearch,
    error_of_warp,
    grid_points,
    nearest_distance,
    search_grid,
)
from shapemorph.methods.synthetic.planar import Exposure, planar_speckle, take_picture
from shapemorph.methods.warp_fit import fit_warp

MAP = np.array([[1.3, -0.4], [0.5, 1.1]])
OFFSET = np.array([90.0, 10.0])
LIGHT = Exposure(gain=0.8, offset=0.02, slope=0.1, noise=2.0, seed=1)
HOW = {
    "step": 17.0,
    "reach": 60.0,
    "half": 11,
    "radius": 6,
    "stride": 2,
    "least_inside": 0.4,
    "least_zncc": 0.6,
}


def inside(points):
    return np.hypot(points[..., 0] - 120, points[..., 1] - 90) < 85


def pictures(diameter):
    speckle = planar_speckle(diameter=diameter, seed=2)
    still = take_picture(speckle, (180, 240), LIGHT, material_at=lambda p: p, inside=inside)
    back = np.linalg.inv(MAP)
    moved = take_picture(
        speckle, (340, 420), LIGHT, material_at=lambda p: (p - OFFSET) @ back.T, inside=inside
    )
    return (even_contrast(picture, window=49) for picture in (still, moved))


def crude_warp(error):
    points = np.random.default_rng(0).uniform([0, 0], [240, 180], (60, 2))
    extent = (np.array([-20.0, -20.0]), np.array([260.0, 200.0]))
    target = (points + error) @ MAP.T + OFFSET
    return fit_warp(points, target, extent=extent, spacing=60.0, smoothing=1e-3)


@pytest.mark.parametrize(("diameter", "reduction"), [(5.0, 1), (11.0, 2)])
def test_error_of_a_crude_warp_is_found_all_over_the_specimen(diameter, reduction):
    error = np.array([1.7, -2.2]) * reduction
    still, moved = pictures(diameter)
    known = np.stack(np.meshgrid([60.0, 120.0, 180.0], [40.0, 90.0, 140.0]), -1).reshape(-1, 2)
    found = search_grid(
        still, moved, crude_warp(error), known, GridSearch(reduction=reduction, **HOW)
    )
    assert len(found.source) > 0.95 * found.asked > 50
    right = found.source @ MAP.T + OFFSET
    misfit = np.linalg.norm(found.target - right, axis=1)
    assert np.median(misfit) < 0.1 * reduction
    assert misfit.max() < 0.6 * reduction
    assert_allclose(np.median(found.shift, axis=0), -error, atol=0.1 * reduction)
    # up to the rim: no point of the disc is far from one that was found
    angle = np.arange(12)
    rim = np.array([120, 90]) + 80 * np.column_stack([np.cos(angle), np.sin(angle)])
    assert nearest_distance(found.source, rim).max() < 1.5 * HOW["step"]


def test_warp_is_not_trusted_far_from_known_points():
    still, moved = pictures(5.0)
    corner = np.array([[70.0, 60.0]])
    found = search_grid(
        still, moved, crude_warp(np.zeros(2)), corner, GridSearch(reduction=1, **HOW)
    )
    assert nearest_distance(corner, found.source).max() < HOW["reach"]


def test_shift_that_mends_the_warp():
    warp = crude_warp(np.array([0.4, -0.3]))
    source = np.array([[100.0, 80.0], [60.0, 120.0]])
    shift = error_of_warp(warp, source, source @ MAP.T + OFFSET)
    assert_allclose(shift, np.tile([-0.4, 0.3], (2, 1)), atol=1e-3)


def test_grid_is_even_and_on_the_mask():
    mask = np.zeros((50, 80), bool)
    mask[10:, :60] = True
    points = grid_points(mask, 7.0)
    assert_allclose(np.diff(np.unique(points[:, 0])), 7.0)
    assert points[:, 0].max() < 60
    assert points[:, 1].min() > 9
