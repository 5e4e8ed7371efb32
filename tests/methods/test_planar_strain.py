"""Strain in the plane against closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import logm

from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.status import PointStatus
from shapemorph.methods.planar_strain import planar_strain

SPACING, SUBSET = 7, 21


def make_grid(move, shape=(12, 15), lost=()):
    rows, cols = np.mgrid[: shape[0], : shape[1]]
    points = SPACING * np.stack([cols + 2, rows + 3], axis=-1).astype(float)
    status = np.zeros(shape, dtype=np.uint8)
    for place in lost:
        status[place] = PointStatus.LOW_ZNCC
    gone = status != 0
    deformed = np.where(gone[..., None], np.nan, move(points))
    nothing = np.full((*shape, 2, 2), np.nan)
    return CorrelationGrid(
        points, deformed, nothing, np.ones(shape), np.ones(shape, dtype=np.int64),
        np.full((*shape, 2), np.nan), status, spacing=SPACING, subset_size=SUBSET,
        kernel_seconds=0.1,
    )  # fmt: skip


@pytest.mark.parametrize(
    "slope",
    [
        [[1.002, 0.0005], [-0.0003, 0.999]],
        [[2.5, 0.4], [-0.3, 0.6]],
        [[0.0, -3.0], [0.3, 0.0]],
    ],
)
def test_a_homogeneous_stretch_of_any_size_is_exact_to_the_rim_and_beside_holes(slope):
    slope = np.array(slope)
    lost = [(slice(4, 7), slice(5, 8)), (0, 0)]
    grid = make_grid(lambda p: p @ slope.T + [300.0, -20.0], lost=lost)
    found = planar_strain(grid, window=5)
    ok = grid.status == 0
    green = (slope.T @ slope - np.eye(2)) / 2
    hencky = logm(slope.T @ slope).real / 2
    assert_allclose(found.green[ok], np.broadcast_to(green, (ok.sum(), 2, 2)), atol=1e-9)
    assert_allclose(found.hencky[ok], np.broadcast_to(hencky, (ok.sum(), 2, 2)), atol=1e-9)
    values = np.sort(np.linalg.eigvalsh(green))[::-1]
    assert_allclose(found.green_principal[ok], np.tile(values, (ok.sum(), 1)), atol=1e-9)
    assert_allclose(found.hencky_principal[ok], np.log(1 + 2 * found.green_principal[ok]) / 2)
    assert np.isnan(found.green[~ok]).all()


def test_a_rotation_is_no_strain():
    turn = np.deg2rad(37.0)
    slope = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    found = planar_strain(make_grid(lambda p: p @ slope.T + 5.0), window=5)
    assert np.abs(found.green).max() < 1e-12


def test_the_gauge_is_stated():
    found = planar_strain(make_grid(lambda p: p), window=9)
    assert (found.window, found.gauge_px) == (9, 8 * SPACING + SUBSET)


def test_a_quadratic_field_is_exact_where_the_window_is_full_and_at_the_rim():
    found = planar_strain(
        make_grid(lambda p: p + np.stack([1e-4 * p[..., 0] ** 2, 0 * p[..., 0]], -1)), window=5
    )
    x = SPACING * (np.arange(15) + 2.0)
    slope = 1 + 2e-4 * x
    assert_allclose(found.green[..., 0, 0], np.tile((slope**2 - 1) / 2, (12, 1)), atol=1e-9)


def test_a_window_that_is_too_empty_gives_nothing():
    lost = [(slice(0, 12), slice(1, 15)), (slice(3, 12), slice(0, 15))]
    grid = make_grid(lambda p: 1.1 * p, lost=lost)  # three points, on a line
    assert grid.ok_count == 3
    assert np.isnan(planar_strain(grid, window=5).green).all()


def test_the_field_does_not_reach_across_a_crack():
    def opened(points):
        return points + np.stack([0 * points[..., 0], 10.0 * (points[..., 1] > 60)], axis=-1)

    row = 6  # y = 63, the first row of the other side
    grid = make_grid(opened, lost=[(row, slice(None))])
    assert np.abs(np.nan_to_num(planar_strain(grid, window=5).green)).max() < 1e-9
