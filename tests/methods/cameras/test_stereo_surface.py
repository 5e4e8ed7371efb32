"""A grid that two cameras see in two states, against points that are known."""

import numpy as np
import pytest

from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.status import PointStatus
from shapemorph.core.stereo_track import StereoGrids
from shapemorph.methods.cameras.stereo_surface import stereo_surface
from shapemorph.methods.synthetic.stereo_rig import stereo_rig

RIG = stereo_rig(scale=0.2, target=np.zeros(3))


def seen(reference_px, points, camera):
    shape = reference_px.shape[:2]
    return CorrelationGrid(
        reference_px=reference_px,
        deformed_px=RIG.cameras[camera].project(points),
        gradient=np.tile(np.eye(2), (*shape, 1, 1)),
        zncc=np.ones(shape),
        iterations=np.ones(shape, dtype=np.int64),
        sigma_px=np.full((*shape, 2), 0.01),
        status=np.zeros(shape, dtype=np.uint8),
        spacing=8,
        subset_size=21,
        kernel_seconds=0.0,
    )


@pytest.fixture
def state():
    """Points of the plane z = 0 and where they go; the grid of the left picture."""
    camera = RIG.cameras[0]
    columns, rows = np.meshgrid(np.arange(160.0, 320, 8), np.arange(120.0, 240, 8))
    pixels = np.stack([columns, rows], axis=-1)
    rays = camera.rays(pixels)
    before = camera.position - rays * (camera.position[2] / rays[..., 2:])
    after = before * [1.1, 0.9, 1.0] + [0.0, 0.0, 3.0]
    grids = StereoGrids(seen(pixels, before, 1), seen(pixels, after, 0), seen(pixels, after, 1))
    return grids, before, after


def test_both_states_are_placed(state):
    grids, before, after = state
    found = stereo_surface(RIG, grids)
    np.testing.assert_allclose(found.reference, before, atol=1e-8)
    np.testing.assert_allclose(found.deformed, after, atol=1e-8)
    np.testing.assert_allclose(
        found.reference_normal, np.broadcast_to([0, 0, 1.0], after.shape), atol=1e-9
    )
    assert 0.003 < np.median(found.sigma_position) < 0.02


def test_a_point_whose_rays_miss_is_an_outlier_and_keeps_its_reference(state):
    grids, before, _ = state
    grids.right.deformed_px[4, 5, 1] += 3.0
    found = stereo_surface(RIG, grids)
    assert found.status[4, 5] == PointStatus.OUTLIER
    assert np.isnan(found.deformed[4, 5]).all()
    np.testing.assert_allclose(found.reference[4, 5], before[4, 5], atol=1e-8)
    assert (found.status != 0).sum() == 1


def test_a_point_that_hardly_any_pattern_holds_has_no_value(state):
    grids, before, _ = state
    grids.right.sigma_px[3, 7] = 0.2
    grids.left.sigma_px[6, 2] = 0.05
    found = stereo_surface(RIG, grids)
    assert found.status[3, 7] == PointStatus.LOW_CONTRAST
    assert np.isnan(found.deformed[3, 7]).all()
    np.testing.assert_allclose(found.reference[3, 7], before[3, 7], atol=1e-8)
    assert (found.status != 0).sum() == 1
