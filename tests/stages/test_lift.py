import numpy as np
import pytest

from shapemorph.config import LiftConfig
from shapemorph.core.errors import StageError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import CalibratedImage, Chart, GreyImage
from shapemorph.core.mesh import coloured_mesh
from shapemorph.core.status import PointStatus
from shapemorph.stages.lift import lift

ROWS, COLS = 40, 50  # px of the pictures


def flattened(place, px_per_mm=4.0, noise=0.0, step=0.9):
    """Mesh over the plane and its picture; `place` carries plane mm to space."""
    size = np.array([COLS - 1, ROWS - 1]) / px_per_mm
    count = np.ceil(size / step).astype(int) + 1
    x, y = np.meshgrid(*(np.linspace(0, s, c) for s, c in zip(size, count, strict=True)))
    flat = np.stack([x, y], axis=-1).reshape(-1, 2)
    i, j = np.meshgrid(np.arange(count[1] - 1), np.arange(count[0] - 1), indexing="ij")
    corner = (i * count[0] + j).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + count[0] + 1], axis=1),
            np.stack([corner, corner + count[0] + 1, corner + count[0]], axis=1),
        ]
    )
    rng = np.random.default_rng(int(1000 * noise))
    vertices = place(flat) + rng.normal(0, noise, (len(flat), 3)) * (noise > 0)
    mesh = coloured_mesh(vertices, faces, np.zeros((len(faces), 3)), name="sheet")
    every = np.arange(len(flat))
    chart = Chart(every, faces, np.arange(len(faces)), flat * px_per_mm, px_per_mm)
    blank = GreyImage(np.zeros((ROWS, COLS), np.float32), np.ones((ROWS, COLS), dtype=bool))
    image = CalibratedImage(
        blank, chart, np.full((ROWS, COLS), -1, np.int32), np.full((ROWS, COLS, 2), np.nan)
    )
    return mesh, image


def plane(flat):
    return np.stack([flat[:, 0] + 100, flat[:, 1], 0.5 * flat[:, 0]], axis=1)


def roll(flat):
    angle = flat[:, 0] / 8
    return np.stack([8 * np.sin(angle), flat[:, 1], 8 * np.cos(angle)], axis=1)


def matched(deformed_px, picture, status=None):
    shape = picture.shape[:2]
    status = np.zeros(shape, dtype=np.uint8) if status is None else status
    lost = (status != PointStatus.OK)[..., None]
    return CorrelationGrid(
        picture,
        np.where(lost, np.nan, deformed_px),
        np.broadcast_to(np.eye(2), (*shape, 2, 2)).copy(),
        np.ones(shape),
        np.ones(shape, dtype=np.int64),
        np.where(lost, np.nan, np.full(picture.shape, 0.05)),
        status,
        6,
        15,
        0.0,
    )


def picture_grid():
    j, i = np.meshgrid(np.arange(0, COLS, 6), np.arange(0, ROWS, 6))
    return np.stack([j, i], axis=-1).astype(float)


def run(grid, reference, deformed, reach=1.0):
    return lift(*reference, *deformed, grid, LiftConfig(max_extrapolation_px=reach))


def test_points_between_pixels_are_placed_exactly_on_flat_faces():
    picture = picture_grid()
    moved = np.clip(0.9 * picture + [1.37, 2.21], 0, [COLS - 1, ROWS - 1])
    found = run(matched(moved, picture), flattened(plane), flattened(plane, step=1.3))
    np.testing.assert_allclose(
        found.reference.reshape(-1, 3), plane(picture.reshape(-1, 2) / 4), atol=1e-12
    )
    np.testing.assert_allclose(
        found.deformed.reshape(-1, 3), plane(moved.reshape(-1, 2) / 4), atol=1e-12
    )
    up = np.array([-0.5, 0, 1]) / np.sqrt(1.25)
    np.testing.assert_allclose(np.abs(found.reference_normal @ up), 1, atol=1e-12)


def test_match_off_the_surface_is_extended_within_reach_and_has_left_beyond_it():
    picture = picture_grid()
    moved = picture.copy()
    moved[0, 0] = [-0.6, 3.0]
    moved[2, 2] = [20.0, -1.5]
    found = run(matched(moved, picture), flattened(plane), flattened(plane))
    np.testing.assert_allclose(found.deformed[0, 0], plane(np.array([[-0.15, 0.75]]))[0])
    assert found.status[2, 2] == PointStatus.LEFT_IMAGE
    assert np.isnan(found.deformed[2, 2]).all()
    assert (found.status == PointStatus.OK).sum() == found.status.size - 1


def test_lost_points_keep_their_reference_position():
    picture = picture_grid()
    status = np.zeros(picture.shape[:2], dtype=np.uint8)
    status[1, 3] = PointStatus.LOW_ZNCC
    found = run(matched(picture, picture, status), flattened(plane), flattened(plane))
    assert np.isfinite(found.reference).all()
    assert found.status[1, 3] == PointStatus.LOW_ZNCC
    assert np.isnan(found.sigma_position[1, 3])


def test_grid_point_off_the_reference_surface_is_outside_the_mask():
    picture = picture_grid()
    picture[0, 0] = [-50.0, 0]
    found = run(matched(np.clip(picture, 0, 39), picture), flattened(plane), flattened(plane))
    assert found.status[0, 0] == PointStatus.OUTSIDE_MASK
    assert np.isnan(found.reference[0, 0]).all()


def test_noise_across_the_surface_and_of_the_match_is_told_by_sigma():
    rng = np.random.default_rng(19)
    j, i = np.meshgrid(np.arange(2.0, COLS - 2, 0.7), np.arange(2.0, ROWS - 2, 0.7))
    picture = np.stack([j, i], axis=-1)
    moved = picture + rng.normal(0, 0.05, picture.shape)
    reference, deformed = flattened(plane, noise=0.01), flattened(plane, noise=0.02)
    found = run(matched(moved, picture), reference, deformed)
    assert found.mesh_noise == pytest.approx([0.01, 0.02], rel=0.15)  # 180 vertices
    normal = np.array([-0.5, 0, 1]) / np.sqrt(1.25)
    across = (found.deformed - found.reference) @ normal
    along = 0.25 * 0.05  # mm/px times px; the slope adds a quarter to one direction
    pattern = (found.sigma_mesh**2).sum(axis=-1) * 2  # noise that the pictures would show
    expected = (np.mean(across**2) + along**2 * 2.25 + pattern.mean()) / 3
    assert np.mean(found.sigma_position**2) == pytest.approx(expected, rel=0.1)


def test_finer_deformed_mesh_disturbs_the_match_less():
    picture = picture_grid()
    coarse, fine = flattened(plane, noise=0.01), flattened(plane, noise=0.01, step=0.45)
    found = run(matched(picture, picture), coarse, fine)
    sides = np.median(found.sigma_mesh, axis=(0, 1))
    assert sides[0] == pytest.approx(2 * sides[1], rel=0.2)  # four times the vertices


def test_a_subset_that_the_rim_halves_is_disturbed_more_than_by_the_missing_vertices():
    picture = picture_grid()
    surface = flattened(plane, noise=0.005, step=0.3)
    sigma = run(matched(picture, picture), surface, surface).sigma_mesh[..., 0]
    inner = np.median(sigma[2:-2, 3:-3])
    half = np.median(sigma[2:-2, 0])
    assert half / inner == pytest.approx(2 * np.sqrt(2), rel=0.15)  # leverage, half the vertices


def test_nothing_on_the_deformed_surface_is_an_error():
    picture = picture_grid()
    with pytest.raises(StageError, match="LEFT_IMAGE"):
        run(matched(picture + 500, picture), flattened(plane), flattened(plane))
