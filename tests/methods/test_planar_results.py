"""The table of a 2D correlation."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.status import PointStatus
from shapemorph.methods.planar_results import planar_table
from shapemorph.methods.planar_strain import planar_strain


@pytest.fixture
def grid():
    """2 x 3 points: one outside the mask, one lost."""
    x, y = np.meshgrid([10.0, 15.0, 20.0], [5.0, 10.0])
    reference = np.stack([x, y], axis=-1)
    slope = np.array([[1.1, 0.02], [-0.03, 0.95]])
    status = np.array([[0, 1, 0], [0, 6, 0]], dtype=np.uint8)
    lost = status != PointStatus.OK
    deformed, gradient = reference @ slope.T + [2.0, -1.0], np.tile(slope, (2, 3, 1, 1))
    deformed[lost], gradient[lost] = np.nan, np.nan
    sigma = np.where(lost[..., None], np.nan, [0.01, 0.02])
    return CorrelationGrid(
        reference, deformed, gradient, np.full((2, 3), 0.9), np.full((2, 3), 4), sigma, status,
        spacing=5, subset_size=15, kernel_seconds=0.1,
    )  # fmt: skip


def _table(grid):
    return planar_table(grid, planar_strain(grid, window=3))


def test_one_row_for_each_point_inside_the_mask(grid):
    table = _table(grid)
    assert {len(column) for column in table.values()} == {5}
    assert_array_equal(table["x_px"], [10, 20, 10, 15, 20])
    assert_array_equal(table["y_px"], [5, 5, 10, 10, 10])
    assert_array_equal(table["status"], [0, 0, 0, 6, 0])


def test_displacement_is_deformed_less_reference(grid):
    table = _table(grid)
    assert table["u_px"][0] == pytest.approx(10 * 0.1 + 5 * 0.02 + 2.0)
    assert table["v_px"][0] == pytest.approx(10 * -0.03 - 5 * 0.05 - 1.0)
    assert_allclose(
        [table[name][1] for name in ("du_dx", "du_dy", "dv_dx", "dv_dy")],
        [0.1, 0.02, -0.03, -0.05],
        atol=1e-12,
    )
    assert (table["sigma_u_px"][0], table["sigma_v_px"][0]) == (0.01, 0.02)


def test_a_lost_point_has_a_status_and_no_numbers(grid):
    table = _table(grid)
    for name in ("u_px", "v_px", "du_dx", "dv_dy", "sigma_u_px"):
        assert np.isnan(table[name][3])
    assert table["zncc"][3] == 0.9


def test_columns_are_those_of_the_contract_and_then_the_strain(grid):
    assert list(_table(grid)) == [
        "x_px",
        "y_px",
        "u_px",
        "v_px",
        "du_dx",
        "du_dy",
        "dv_dx",
        "dv_dy",
        "zncc",
        "iterations",
        "status",
        "sigma_u_px",
        "sigma_v_px",
        "bias_u_px",
        "bias_v_px",
        "E_xx",
        "E_xy",
        "E_yy",
        "E1",
        "E2",
        "hencky_xx",
        "hencky_xy",
        "hencky_yy",
        "hencky_1",
        "hencky_2",
    ]
