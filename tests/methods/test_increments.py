"""Increments put together against fields that are known exactly."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.status import PointStatus
from shapemorph.methods.increments import compose_grids, continued, lost_grid, warp_through
from shapemorph.methods.laws.identity import identity_warp
from shapemorph.methods.warping import warp_points

SPACING, SUBSET = 8, 21
SHOWN = np.ones((400, 400), dtype=bool)


def bend(points):
    """Quadratic map and its gradient."""
    x, y = np.moveaxis(points, -1, 0)
    u = 3.0 + 0.05 * x - 0.02 * y + 3e-4 * x * y + 2e-4 * x**2
    v = -2.0 + 0.01 * x + 0.04 * y - 2e-4 * y**2
    slope = np.stack(
        [1.05 + 3e-4 * y + 4e-4 * x, -0.02 + 3e-4 * x, 0.01 + 0 * x, 1.04 - 4e-4 * y], axis=-1
    )
    return points + np.stack([u, v], axis=-1), slope.reshape(*points.shape, 2)


def turn(points):
    slope = np.array([[0.9, -0.3], [0.2, 1.1]])
    return points @ slope.T + [5.0, 1.0], np.broadcast_to(slope, (*points.shape, 2))


def make_grid(move, shape=(20, 22), start=(2, 2), lost=(), sigma=0.01):
    rows, cols = np.mgrid[: shape[0], : shape[1]]
    points = SPACING * np.stack([cols + start[0], rows + start[1]], axis=-1).astype(float)
    status = np.zeros(shape, dtype=np.uint8)
    for place, code in lost:
        status[place] = code
    gone = status != 0
    deformed, gradient = move(points)
    return CorrelationGrid(
        points, np.where(gone[..., None], np.nan, deformed),
        np.where(gone[..., None, None], np.nan, gradient), np.where(gone, 0.2, 0.97),
        np.full(shape, 4), np.where(gone[..., None], np.nan, [sigma, sigma]), status,
        spacing=SPACING, subset_size=SUBSET, kernel_seconds=0.1,
    )  # fmt: skip


def test_quadratic_increments_compose_exactly():
    first = make_grid(turn, shape=(10, 10), start=(5, 4))
    second = make_grid(bend, shape=(40, 40), start=(0, 0))
    found = compose_grids(first, second, shown=SHOWN)
    expected, slope = bend(first.deformed_px)
    assert (found.status == PointStatus.OK).all()
    assert_allclose(found.deformed_px, expected, atol=1e-9)
    assert_allclose(found.gradient, slope @ turn(first.reference_px)[1], atol=1e-9)


def test_random_errors_add_as_variances():
    first = make_grid(lambda p: (p + 3.2, np.broadcast_to(np.eye(2), (*p.shape, 2))), (6, 6))
    second = make_grid(
        lambda p: (2.0 * p, np.broadcast_to(2.0 * np.eye(2), (*p.shape, 2))), (20, 20), (0, 0),
        sigma=0.03,
    )  # fmt: skip
    sigma = compose_grids(first, second, shown=SHOWN).sigma_px
    assert_allclose(sigma, np.hypot(2 * 0.01, 0.03), rtol=1e-9)


def test_a_lost_point_stays_lost_and_says_why():
    first = make_grid(turn, (10, 10), (5, 4), lost=[((3, 3), PointStatus.LOW_ZNCC)])
    second = make_grid(bend, (40, 40), (0, 0))
    found = compose_grids(first, second, shown=SHOWN)
    assert found.status[3, 3] == PointStatus.LOW_ZNCC
    assert np.isnan(found.deformed_px[3, 3]).all()
    assert found.ok_count == 99


def test_nothing_is_extrapolated_where_the_increment_has_nothing():
    first = make_grid(turn, shape=(10, 10), start=(5, 4))
    hole = (slice(8, 16), slice(3, 12))
    second = make_grid(bend, (40, 40), (0, 0), lost=[(hole, PointStatus.NOT_CONVERGED)])
    found = compose_grids(first, second, shown=SHOWN)
    gone = found.status != PointStatus.OK
    assert set(found.status[gone]) == {PointStatus.NOT_CONVERGED}
    place = first.deformed_px / SPACING
    deep = (np.abs(place - [7.0, 11.5]) < np.array([3.0, 2.5])).all(axis=-1)
    assert gone[deep].all()
    expected = bend(first.deformed_px)[0]
    assert_allclose(found.deformed_px[~gone], expected[~gone], atol=0.02)  # linear at the rim


def test_what_leaves_the_picture_is_lost():
    first = make_grid(turn, shape=(10, 10), start=(5, 4))
    second = make_grid(bend, (12, 40), (0, 0))
    found = compose_grids(first, second, shown=SHOWN)
    outside = first.deformed_px[..., 1] > 12 * SPACING
    assert outside.any()
    assert (found.status[outside] == PointStatus.LEFT_IMAGE).all()


def test_what_the_picture_does_not_show_is_lost():
    first = make_grid(turn, shape=(10, 10), start=(5, 4))
    second = make_grid(bend, (40, 40), (0, 0))
    shown = SHOWN.copy()
    shown[:, 100:] = False
    found = compose_grids(first, second, shown=shown)
    hidden = bend(first.deformed_px)[0][..., 0] > 99.5
    assert 0 < hidden.sum() < hidden.size
    assert (found.status[hidden] == PointStatus.LEFT_IMAGE).all()
    assert (found.status[~hidden] == PointStatus.OK).all()


def test_a_warp_through_a_grid_follows_it():
    grid = make_grid(bend)
    warp = warp_through(grid, identity_warp((200, 200)))
    inner = grid.reference_px[2:-2, 2:-2].reshape(-1, 2)
    assert_allclose(warp_points(warp, inner)[0], bend(inner)[0], atol=0.02)


def test_a_warp_through_a_grid_passes_over_lost_points():
    lost = make_grid(bend, lost=[((3, 4), PointStatus.OUTLIER), ((9, 9), PointStatus.LOW_ZNCC)])
    warp = warp_through(lost, identity_warp((200, 200)))
    at = lost.reference_px[3:10, 4:10].reshape(-1, 2)
    assert_allclose(warp_points(warp, at)[0], bend(at)[0], atol=0.05)


def test_a_lost_grid_has_the_points_of_the_mask():
    mask = np.zeros((40, 60), dtype=bool)
    mask[10:30, 20:50] = True
    mask[16, 24] = False
    gone = lost_grid(mask, spacing=8, subset_size=SUBSET, status=PointStatus.NOT_SEEDED)
    assert gone.reference_px[0, 0].tolist() == [24, 16]
    assert gone.status[0, 0] == PointStatus.OUTSIDE_MASK
    assert (gone.status == PointStatus.NOT_SEEDED).sum() == gone.status.size - 1
    assert gone.ok_count == 0


@pytest.mark.parametrize("size", [(1, 6), (6, 1)])
def test_a_single_row_of_points_is_a_grid_too(size):
    first = make_grid(lambda p: (p + 0.0, np.broadcast_to(np.eye(2), (*p.shape, 2))), size)
    found = compose_grids(first, make_grid(turn, size), shown=SHOWN)
    assert_allclose(found.deformed_px, turn(first.reference_px)[0], atol=1e-9)


def test_systematic_errors_add_in_the_last_picture():
    first, second = make_grid(turn, (10, 10), (5, 4)), make_grid(bend, (40, 40), (0, 0))
    assert compose_grids(first, second, shown=SHOWN).bias_px is None
    bias = [np.broadcast_to(each, (*g.status.shape, 2)) for each, g in
            (([0.02, -0.01], first), ([0.003, 0.004], second))]  # fmt: skip
    first, second = replace(first, bias_px=bias[0]), replace(second, bias_px=bias[1])
    found = compose_grids(first, second, shown=SHOWN)
    slope = bend(first.deformed_px)[1]
    ok = found.status == PointStatus.OK
    assert_allclose(found.bias_px[ok], (slope @ bias[0][0, 0] + bias[1][0, 0])[ok], atol=2e-4)


def test_motion_goes_on_as_it_came():
    """A point that came from y to x goes on to 2 x - y, beyond what was measured too."""
    slope, shift = np.array([[1.03, -0.02], [0.01, 0.99]]), np.array([9.0, -4.0])
    grid = make_grid(lambda points: (points @ slope.T + shift, np.broadcast_to(
        slope, (*points.shape, 2)
    )))  # fmt: skip
    came = warp_through(grid, identity_warp((200, 220)))
    at = np.random.default_rng(1).uniform([40, 30], [160, 150], (50, 2))
    found, gradient = warp_points(continued(grid, came, (200, 220)), at)
    back = np.linalg.inv(slope)
    assert_allclose(found, 2 * at - (at - shift) @ back.T, atol=0.01)
    assert_allclose(gradient, np.broadcast_to(2 * np.eye(2) - back, (50, 2, 2)), atol=3e-3)
    corners = np.array([[0.0, 0.0], [219.0, 199.0]])
    assert np.isfinite(warp_points(continued(grid, came, (200, 220)), corners)[0]).all()
