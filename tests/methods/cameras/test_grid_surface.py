import numpy as np
import pytest

from shapemorph.core.camera import Rig
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.status import PointStatus
from shapemorph.methods.cameras.grid_surface import mesh_of, place_grid, smooth_disparities

SPACING, SIGMA = 20, 0.03


@pytest.fixture(scope="module")
def rig(stereo_pair):
    return Rig(stereo_pair, ("left", "right"))


@pytest.fixture(scope="module")
def surface(rig):
    """A grid of the left picture, a bent surface under it, and where the right camera sees it."""
    left, right = rig.cameras
    columns, rows = np.meshgrid(np.arange(900, 1500, SPACING), np.arange(700, 1100, SPACING))
    pixels = np.stack([columns, rows], axis=-1).astype(np.float64)
    rays = left.rays(pixels)
    depth = 430 - 3e-5 * ((pixels - left.centre) ** 2).sum(axis=-1)
    points = rays * (depth / rays[..., 2])[..., None]
    return pixels, points, right.project(points)


def grid_of(pixels, matched, sigma=SIGMA):
    status = np.where(np.isfinite(matched).all(axis=-1), 0, PointStatus.LOW_ZNCC).astype(np.uint8)
    shape = status.shape
    lost = (status != 0)[..., None]
    return CorrelationGrid(
        reference_px=pixels,
        deformed_px=matched,
        gradient=np.zeros((*shape, 2, 2)),
        zncc=np.ones(shape),
        iterations=np.ones(shape, dtype=np.int64),
        sigma_px=np.where(lost, np.nan, np.full((*shape, 2), sigma)),
        status=status,
        spacing=SPACING,
        subset_size=21,
        kernel_seconds=0.0,
    )


def test_exact_matches_lie_on_the_surface(rig, surface):
    pixels, points, matched = surface
    matched = matched.copy()
    matched[3, 4] = np.nan
    found = place_grid(rig, grid_of(pixels, matched), limit=None, smoothed=None)
    ok = found.status == 0
    assert found.status[3, 4] == PointStatus.LOW_ZNCC
    assert ok.sum() == ok.size - 1
    np.testing.assert_allclose(found.points[ok], points[ok], atol=1e-6)


def test_uncertainty_and_epipolar_error_are_those_of_the_noise(rig, surface):
    pixels, points, matched = surface
    noise = np.random.default_rng(0).normal(0, SIGMA, matched.shape)
    found = place_grid(rig, grid_of(pixels, matched + noise), limit=None, smoothed=None)
    ok = found.status == 0
    share = (np.abs(found.points - points)[ok] < found.sigma[ok]).mean(axis=0)
    assert ((share > 0.6) & (share < 0.76)).all()
    assert np.sqrt((found.epipolar_px[ok] ** 2).mean()) == pytest.approx(SIGMA, rel=0.1)


def test_a_match_off_its_line_is_lost(rig, surface):
    pixels, _, matched = surface
    matched = matched + np.random.default_rng(1).normal(0, SIGMA, matched.shape)
    matched[5, 6] += [0.0, 1.0]
    found = place_grid(rig, grid_of(pixels, matched), limit=None, smoothed=None)
    assert found.status[5, 6] == PointStatus.OUTLIER
    assert (found.status == 0).sum() == found.status.size - 1
    assert np.isnan(found.points[5, 6]).all()
    assert found.epipolar_px[5, 6] > 0.8


def test_smoothing_takes_noise_away_and_no_shape(rig, surface):
    pixels, points, matched = surface
    noise = np.random.default_rng(2).normal(0, SIGMA, matched.shape)
    raw = grid_of(pixels, matched + noise)
    smooth, moved = smooth_disparities(raw)
    assert moved == pytest.approx(SIGMA * np.sqrt(2), rel=0.2)
    error = {}
    for name, grid in (("raw", raw), ("smooth", smooth)):
        found = place_grid(rig, grid, limit=None, smoothed=None)
        ok = found.status == 0
        error[name] = np.sqrt(((found.points - points)[ok] ** 2).mean())
    assert error["smooth"] < 0.5 * error["raw"]


def test_the_mesh_faces_the_cameras_and_holds_the_mean_of_both(rig, surface):
    pixels, points, matched = surface
    matched = matched.copy()
    matched[8, 8] = np.nan
    found = place_grid(rig, grid_of(pixels, matched), limit=None, smoothed=None)
    width, height = rig.cameras[0].size
    whole = np.ones((height, width), dtype=bool)
    dark, light = (GreyImage(np.full((height, width), g, np.float32), whole) for g in (0.3, 0.5))
    mesh = mesh_of(found, dark, light)
    cells = (pixels.shape[0] - 1) * (pixels.shape[1] - 1)
    assert len(mesh.vertices) == points.shape[0] * points.shape[1] - 1
    assert len(mesh.faces) == 2 * cells - 4  # a hole of one corner: four half cells
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (normals[:, 2] < 0).all()  # towards the camera, which looks along +z
    at = mesh.wedge_uv[0, 0] * [width, -height] + [-0.5, height - 0.5]
    seen = rig.cameras[0].project(corners[0, 0])
    np.testing.assert_allclose(at, seen, atol=1e-6)
    assert mesh.textures[0][900, 1200] == pytest.approx(0.4, abs=1e-6)
