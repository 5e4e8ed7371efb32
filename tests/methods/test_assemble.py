from dataclasses import replace

import numpy as np
import pytest

from shapemorph.config import StrainConfig
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.status import PointStatus
from shapemorph.core.surface import Alignment, TrackedSurface
from shapemorph.io.quantities import FACET_ARRAYS, QUANTITIES
from shapemorph.methods.assemble import assemble_measurement
from shapemorph.methods.charts.ownership import Ownership
from shapemorph.methods.facet_strain import triangle_strain
from shapemorph.methods.principal import principal
from shapemorph.stages.strain import strain

TURN = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
SHIFT = np.array([5.0, 6, 7])


def case(normal=1.0):
    """Sheet of 9 x 12 points stretched by 2 and 1.5, turned; some points lost."""
    j, i = np.meshgrid(np.arange(12), np.arange(9))
    picture = np.stack([j, i], axis=-1) * 10.0
    status = np.zeros(j.shape, dtype=np.uint8)
    status[:, 0] = PointStatus.OUTSIDE_MASK
    status[3, 6] = PointStatus.LOW_ZNCC
    status[6:, 9:] = PointStatus.NOT_SEEDED
    status[8, 11] = PointStatus.OK  # alone
    lost = (status != PointStatus.OK)[..., None]
    reference = np.stack([j, i, 0 * j], axis=-1) * 1.0
    reference[status == PointStatus.OUTSIDE_MASK] = np.nan
    in_frame = reference * [2.0, 1.5, 1.0]
    deformed = np.where(lost, np.nan, (in_frame - SHIFT) @ TURN)
    up = np.broadcast_to([0.0, 0, normal], reference.shape)
    sigma = np.where(lost[..., 0], np.nan, 0.004)
    tracked = TrackedSurface(
        reference,
        deformed,
        np.where(np.isnan(reference), np.nan, up),
        np.where(lost, np.nan, up),
        sigma,
        status,
        np.zeros(2),
    )
    grid = CorrelationGrid(
        picture,
        np.where(lost, np.nan, picture * [2, 1.5]),
        np.zeros((*j.shape, 2, 2)),
        np.full(j.shape, 0.9),
        np.full(j.shape, 4),
        np.where(lost, np.nan, np.full(picture.shape, 0.02)),
        status,
        10,
        21,
        0.1,
    )
    nothing = np.zeros(0, dtype=np.int64)
    alignment = Alignment(TURN, SHIFT, "points", 0.0, np.zeros(1), 1, 1.0, nothing, "")
    return grid, tracked, alignment, strain(tracked, grid, StrainConfig()), one_page(status)


def one_page(status):
    nothing = np.zeros(status.shape)
    return Ownership(nothing.astype(np.int64), nothing == 0, nothing, nothing.copy())


@pytest.fixture(scope="module")
def measurement():
    return assemble_measurement(*case())


def test_arrays_have_the_names_of_the_contract_and_a_row_each(measurement):
    assert set(measurement.arrays) == {q.name for q in QUANTITIES if not q.only_with}
    assert len(measurement.reference) == 9 * 11  # the column outside the mask has no rows
    assert measurement.arrays["status"].dtype == np.uint8
    assert measurement.arrays["chart"].dtype == np.int64


def test_reference_positions_are_finite_for_lost_points_too(measurement):
    assert np.isfinite(measurement.reference).all()
    assert np.isfinite(measurement.arrays["reference_px"]).all()


def test_values_are_missing_exactly_where_the_status_is_not_ok(measurement):
    lost = measurement.arrays["status"] != PointStatus.OK
    for name in ("deformed_position", "displacement", "deformed_px", "E1", "sigma_E2"):
        missing = np.isnan(measurement.arrays[name]).reshape(len(lost), -1).any(axis=1)
        np.testing.assert_array_equal(missing, lost, err_msg=name)


def test_followed_point_without_a_strain_is_a_degenerate_facet(measurement):
    at_corner = np.flatnonzero((measurement.reference == [11, 8, 0]).all(axis=1))
    assert measurement.arrays["status"][at_corner] == PointStatus.DEGENERATE_FACET


def test_displacement_is_taken_after_the_alignment(measurement):
    sound = measurement.arrays["status"] == PointStatus.OK
    expected = measurement.reference * [1.0, 0.5, 0.0]
    np.testing.assert_allclose(
        measurement.arrays["displacement"][sound], expected[sound], atol=1e-12
    )


def test_measures_agree_with_the_stretches(measurement):
    sound = measurement.arrays["status"] == PointStatus.OK
    expected = {
        "E1": 1.5,
        "E2": 0.625,
        "stretch_1": 2.0,
        "stretch_2": 1.5,
        "hencky_1": np.log(2),
        "hencky_2": np.log(1.5),
        "thickness_strain": -np.log(3),
        "anisotropy": 2.4,
    }
    for name, value in expected.items():
        np.testing.assert_allclose(measurement.arrays[name][sound], value, atol=1e-9, err_msg=name)
    directions = np.abs(measurement.arrays["direction_1"][sound])
    np.testing.assert_allclose(directions, np.broadcast_to([1, 0, 0], directions.shape), atol=1e-9)
    turned = np.abs(measurement.arrays["direction_1_deformed"][sound])
    np.testing.assert_allclose(turned, np.broadcast_to([0, 1, 0], turned.shape), atol=1e-9)


def test_anisotropy_is_missing_where_e2_is_within_its_noise():
    grid, tracked, alignment, field, pages = case()
    field.e2[:] = 0.5 * field.sigma_e2
    found = assemble_measurement(grid, tracked, alignment, field, pages)
    assert np.isnan(found.arrays["anisotropy"]).all()
    assert np.isfinite(found.arrays["E2"]).any()


def test_cells_join_only_ok_neighbours_and_lost_point_costs_only_its_own(measurement):
    status = measurement.arrays["status"]
    assert (status[measurement.cells] == PointStatus.OK).all()
    # 8 x 10 cells, less 4 around the lost point and 9 around the lost corner
    assert len(measurement.cells) == 80 - 4 - 9


@pytest.mark.parametrize("normal", [1.0, -1.0])
def test_cells_turn_counter_clockwise_seen_from_the_outer_side(normal):
    found = assemble_measurement(*case(normal))
    corners = found.reference[found.cells]
    across = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    assert (across[:, 2] * normal > 0).all()


def test_a_repeated_point_stays_only_as_the_corner_of_a_cell_on_the_seam():
    grid, tracked, alignment, field, pages = case()
    columns = grid.reference_px[..., 0]
    pages.owned[:] = columns < np.median(columns)
    pages.page[:] = columns > np.percentile(columns, 20)
    found = assemble_measurement(grid, tracked, alignment, field, pages)
    kept = np.zeros(grid.status.size, dtype=bool)
    kept[found.grid_index] = True
    per_column = kept.reshape(grid.status.shape).any(axis=0)
    inside = (grid.status != PointStatus.OUTSIDE_MASK).any(axis=0)
    owned = pages.owned.any(axis=0)
    seam = np.flatnonzero(owned)[-1] + 1
    np.testing.assert_array_equal(per_column, inside & (owned | (np.arange(len(owned)) == seam)))
    assert set(found.arrays["chart"]) == {0, 1}


def test_positions_are_those_in_the_picture_of_the_page():
    grid, tracked, alignment, field, pages = case()
    pages.reference_left[:] = 100.0
    pages.deformed_left[:] = 7.0
    found = assemble_measurement(grid, tracked, alignment, field, pages)
    whole = assemble_measurement(*case())
    moved = whole.arrays["reference_px"] - found.arrays["reference_px"]
    np.testing.assert_allclose(moved, np.broadcast_to([100.0, 0.0], moved.shape))
    moved = whole.arrays["deformed_px"] - found.arrays["deformed_px"]
    np.testing.assert_allclose(moved[np.isfinite(moved[:, 0])][0], [7.0, 0.0])


def test_facets_have_the_strain_of_the_sheet_and_turn_the_way_of_the_quads(measurement):
    facets = measurement.facets
    assert len(facets.corners) == 2 * len(measurement.cells)
    assert set(facets.arrays) == set(FACET_ARRAYS)
    np.testing.assert_allclose(facets.arrays["stretch_1"], 2, rtol=1e-12)
    np.testing.assert_allclose(facets.arrays["engineering_2"], 0.5, rtol=1e-12)
    for sign in (1.0, -1.0):
        found = assemble_measurement(*case(sign))
        corners = found.reference[found.facets.corners]
        sides = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        assert (np.cross(*sides)[:, 2] * sign > 0).all()


def test_every_facet_has_the_strain_of_its_own_corners():
    grid, tracked, alignment, _, ownership = case()
    rng = np.random.default_rng(2)
    moved = replace(tracked, deformed=tracked.deformed + rng.normal(size=(9, 12, 3)) * 0.1)
    field = strain(moved, grid, StrainConfig())
    for normal in (1.0, -1.0):
        turned = replace(moved, reference_normal=normal * tracked.reference_normal)
        found = assemble_measurement(grid, turned, alignment, field, ownership)
        tensor = triangle_strain(
            found.reference, found.arrays["deformed_position"], found.facets.corners
        )
        values, _ = principal(tensor)
        np.testing.assert_allclose(found.facets.arrays["E1"], values[:, 0], atol=1e-12)
        np.testing.assert_allclose(found.facets.arrays["E2"], values[:, 1], atol=1e-12)
