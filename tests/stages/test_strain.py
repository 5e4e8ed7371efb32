from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapemorph.config import StrainConfig
from shapemorph.core.errors import StageError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.status import PointStatus
from shapemorph.core.surface import TrackedSurface
from shapemorph.stages.strain import strain

TURN = Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix()
SPACING, SUBSET = 8, 21


def case(place, status=None, rows=11, cols=14, pitch=0.5, sigma_px=0.02):
    """Flat oblique sheet and where `place` (R, C, 2) -> (R, C, 3) puts it."""
    j, i = np.meshgrid(np.arange(cols), np.arange(rows))
    flat = np.stack([j + 0.3 * i - 5, 0.8 * i - 4], axis=-1) * pitch
    picture = np.stack([j, i], axis=-1) * float(SPACING)
    status = np.zeros(j.shape, dtype=np.uint8) if status is None else status
    lost = (status != PointStatus.OK)[..., None]
    reference = np.concatenate([flat, np.zeros((rows, cols, 1))], axis=-1) @ TURN.T
    normal = np.broadcast_to(TURN[:, 2], reference.shape)
    deformed = np.where(lost, np.nan, place(flat))
    tracked = TrackedSurface(
        reference,
        deformed,
        normal,
        np.where(lost, np.nan, normal),
        np.where(lost[..., 0], np.nan, 0.003),
        status,
        np.zeros(2),
    )
    grid = CorrelationGrid(
        picture,
        np.where(lost, np.nan, picture * 1.1),
        np.zeros((*j.shape, 2, 2)),
        np.ones(j.shape),
        np.ones(j.shape, dtype=np.int64),
        np.where(lost, np.nan, np.full(picture.shape, sigma_px)),
        status,
        SPACING,
        SUBSET,
        0.0,
    )
    return tracked, grid


def stretched(flat):
    """Stretch by 3 along x and 0.5 along y."""
    return np.stack([3 * flat[..., 0], 0.5 * flat[..., 1], 0 * flat[..., 0]], axis=-1)


def rising(flat):
    """Stretch by 1 to some 1.8 along x, as its cube."""
    x, y = flat[..., 0], flat[..., 1]
    return np.stack([x + 0.02 * x**3, y, 0 * x], axis=-1)


def test_strain_follows_to_the_rim_where_the_noise_is_known_and_small():
    tracked, grid = case(rising)
    noise = np.broadcast_to(1e-8 * np.eye(3), (*tracked.status.shape, 3, 3))
    x = (tracked.reference @ TURN)[:, -1, 0]  # a rim column
    true = ((1 + 0.06 * x**2) ** 2 - 1) / 2
    plain = strain(tracked, grid, StrainConfig()).e1[:, -1]
    found = strain(replace(tracked, covariance=noise), grid, StrainConfig()).e1[:, -1]
    assert np.abs(plain - true).max() > 0.05
    np.testing.assert_allclose(found, true, atol=1e-3)


def test_homogeneous_stretch_has_its_principal_values_and_directions_in_both_states():
    field = strain(*case(stretched), StrainConfig())
    np.testing.assert_allclose(field.e1, 4, atol=1e-9)
    np.testing.assert_allclose(field.e2, -0.375, atol=1e-9)
    along = np.abs(field.direction_1 @ TURN[:, 0])
    np.testing.assert_allclose(along, 1, atol=1e-9)
    np.testing.assert_allclose(np.abs(field.direction_1_deformed[..., 0]), 1, atol=1e-9)


def test_gradient_and_tensor_agree_with_the_bases_they_are_given_in():
    field = strain(*case(stretched), StrainConfig())
    metric = np.swapaxes(field.gradient, -1, -2) @ field.gradient
    np.testing.assert_allclose(field.tensor, (metric - np.eye(2)) / 2, atol=1e-12)
    step = np.array([1.0, 0, 0]) @ TURN.T  # the grid's columns run along x
    np.testing.assert_allclose(
        field.tangent[..., 0, :], np.broadcast_to(step, (11, 14, 3)), atol=1e-9
    )
    for basis in (field.tangent, field.deformed_tangent):
        products = basis @ np.swapaxes(basis, -1, -2)
        np.testing.assert_allclose(products, np.broadcast_to(np.eye(2), products.shape), atol=1e-12)


def test_facets_and_window_agree_on_a_homogeneous_stretch():
    field = strain(*case(stretched), StrainConfig())
    np.testing.assert_allclose(
        field.facet_tensor, np.broadcast_to(field.tensor[0, 0], field.facet_tensor.shape), atol=1e-9
    )


def test_rigid_motion_has_no_strain_and_no_direction():
    field = strain(*case(lambda flat: stretched(flat) / [3, 0.5, 1]), StrainConfig())
    np.testing.assert_allclose(field.e1, 0, atol=1e-12)
    assert np.isnan(field.direction_1).all()
    assert np.isnan(field.direction_1_deformed).all()


def test_lost_points_have_no_strain_and_cost_no_neighbour_theirs():
    status = np.zeros((11, 14), dtype=np.uint8)
    status[4:6, 5:8] = PointStatus.NOT_CONVERGED
    tracked, grid = case(stretched, status)
    field = strain(tracked, grid, StrainConfig())
    np.testing.assert_array_equal(np.isfinite(field.e1), status == 0)
    np.testing.assert_array_equal(np.isfinite(field.sigma_e1), status == 0)


def test_noise_is_larger_at_the_rim_and_grows_with_the_noise_of_the_match():
    quiet = strain(*case(stretched), StrainConfig())
    loud = strain(*case(stretched, sigma_px=0.04), StrainConfig())
    np.testing.assert_allclose(loud.sigma_e1, 2 * quiet.sigma_e1, rtol=1e-9)
    assert quiet.sigma_e1[5, 0] > 2 * quiet.sigma_e1[5, 7]


def test_wider_window_has_less_noise_and_a_longer_gauge():
    narrow = strain(*case(stretched), StrainConfig(window=5))
    wide = strain(*case(stretched), StrainConfig(window=7))
    assert np.median(wide.sigma_e1) < np.median(narrow.sigma_e1)
    assert narrow.gauge_px == 4 * SPACING + SUBSET
    assert wide.gauge_px == 6 * SPACING + SUBSET
    # oblique grid of 0.5 x 0.4 mm at 8 px: the scale is the root of the area
    assert narrow.gauge_mm == pytest.approx(narrow.gauge_px * np.sqrt(0.5 * 0.4) / SPACING)


def test_rigid_motion_of_the_deformed_file_changes_nothing():
    field = strain(*case(stretched), StrainConfig())
    moved = strain(*case(lambda flat: stretched(flat) @ TURN + [50, 60, 70]), StrainConfig())
    np.testing.assert_allclose(moved.tensor, field.tensor, atol=1e-9)
    np.testing.assert_allclose(moved.sigma_e1, field.sigma_e1, rtol=1e-6)


def test_nothing_with_neighbours_is_an_error_not_zero_strain():
    status = np.full((11, 14), PointStatus.LOW_ZNCC, dtype=np.uint8)
    status[::5, ::5] = PointStatus.OK
    with pytest.raises(StageError, match="got none"):
        strain(*case(stretched, status), StrainConfig())
