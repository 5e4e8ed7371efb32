"""Wrong points among right ones, and right ones that look odd."""

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from shapemorph.core.status import PointStatus
from shapemorph.methods.correlation_checks import find_outliers, neighbour_guesses

SPACING, FLOOR = 5, 0.15
ROWS, COLS = 18, 24


def _grid():
    y, x = np.mgrid[:ROWS, :COLS] * float(SPACING)
    return np.stack([x, y], axis=-1)


def _field(function, noise=0.01, seed=0):
    """Positions and gradients of a map, with the noise of a match."""
    points, step = _grid(), 1e-4
    rng = np.random.default_rng(seed)
    right, down = np.array([step, 0.0]), np.array([0.0, step])
    along_x = (function(points + right) - function(points - right)) / (2 * step)
    along_y = (function(points + down) - function(points - down)) / (2 * step)
    gradient = np.stack([along_x, along_y], axis=-1)
    position = function(points) + rng.normal(0, noise, points.shape)
    return position, gradient + rng.normal(0, noise / 8, gradient.shape)


def _outliers(position, gradient, status=None):
    status = np.zeros((ROWS, COLS), dtype=np.uint8) if status is None else status
    return find_outliers(position, gradient, status, spacing=SPACING, floor=FLOOR)[0]


def _smooth(points):
    x, y = points[..., 0], points[..., 1]
    bump = 1.5 * np.exp(-((x - 60) ** 2 + (y - 40) ** 2) / 900)
    return points + np.stack([bump, -0.7 * bump], axis=-1)


def _kinked(points):
    """Stretch jumps from 1 to 1.25 across an oblique line: a die edge."""
    beyond = np.maximum(points[..., 0] + 0.4 * points[..., 1] - 70, 0)
    return points + np.stack([0.25 * beyond, 0.05 * beyond], axis=-1)


def test_a_smooth_field_has_no_outliers():
    assert not _outliers(*_field(_smooth)).any()


def test_points_at_a_kink_stay():
    assert not _outliers(*_field(_kinked)).any()


def test_single_wrong_points_are_found_and_their_neighbours_stay():
    position, gradient = _field(_smooth)
    wrong = np.zeros((ROWS, COLS), dtype=bool)
    wrong[[3, 9, 9, 17, 0], [4, 12, 14, 23, 11]] = True
    position[wrong] += [0.5, -0.4]
    assert_array_equal(_outliers(position, gradient), wrong)


def test_a_wrong_point_beside_a_kink_is_found():
    position, gradient = _field(_kinked)
    position[8, 11] += [1.6, -1.2]
    found = _outliers(position, gradient)
    assert found[8, 11]
    assert found.sum() == 1


def test_a_cluster_of_wrong_points_at_the_rim_is_found():
    position, gradient = _field(_smooth)
    wrong = np.zeros((ROWS, COLS), dtype=bool)
    wrong[0:2, 10:12] = True
    position[wrong] += [3.0, 2.0]
    assert_array_equal(_outliers(position, gradient), wrong)


def test_a_row_of_wrong_points_that_agree_with_each_other_is_found():
    position, gradient = _field(_smooth)
    wrong = np.zeros((ROWS, COLS), dtype=bool)
    wrong[8, 6:14] = True
    position[wrong] += [0.6, -0.5]
    assert_array_equal(_outliers(position, gradient), wrong)


def test_lost_points_neither_speak_nor_are_judged():
    position, gradient = _field(_smooth)
    status = np.zeros((ROWS, COLS), dtype=np.uint8)
    status[:, 5:8] = PointStatus.NOT_CONVERGED
    position[:, 5:8] = 1e6
    assert not _outliers(position, gradient, status).any()


def test_a_few_points_cut_off_from_the_rest_that_contradict_it_are_dropped():
    position, gradient = _field(_smooth)
    status = np.full((ROWS, COLS), PointStatus.OUTSIDE_MASK, dtype=np.uint8)
    status[:, :10] = PointStatus.OK
    status[3:5, 14:16] = PointStatus.OK
    assert_array_equal(np.argwhere(_outliers(position, gradient, status))[:, 1], [14, 15, 14, 15])


def test_guesses_for_lost_points_come_from_the_neighbours():
    position, gradient = _field(_smooth, noise=0.0)
    usable = np.ones((ROWS, COLS), dtype=bool)
    usable[6:8, 6:8] = False
    queries = np.argwhere(~usable)
    guess, slope, known = neighbour_guesses(position, gradient, usable, queries, spacing=SPACING)
    assert known.all()
    truth = _smooth(_grid())[~usable]
    assert_allclose(guess, truth, atol=0.1)  # the curvature over two spacings
    assert_allclose(slope, gradient[~usable], atol=0.05)


def test_no_guess_without_neighbours():
    position, gradient = _field(_smooth)
    usable = np.zeros((ROWS, COLS), dtype=bool)
    usable[0, :3] = True
    _, _, known = neighbour_guesses(
        position, gradient, usable, np.array([[1, 1], [9, 9]]), spacing=SPACING
    )
    assert_array_equal(known, [True, False])


def test_single_points_that_nobody_confirms_are_dropped_even_if_there_is_nothing_else():
    position, gradient = _field(_smooth)
    status = np.full((ROWS, COLS), PointStatus.LOW_ZNCC, dtype=np.uint8)
    status[[2, 9, 15], [3, 12, 20]] = PointStatus.OK
    assert_array_equal(_outliers(position, gradient, status), status == PointStatus.OK)


def test_a_handful_of_points_may_be_all_there_is():
    position, gradient = _field(_smooth)
    status = np.full((ROWS, COLS), PointStatus.OUTSIDE_MASK, dtype=np.uint8)
    status[4:6, 7:9] = PointStatus.OK
    assert not _outliers(position, gradient, status).any()


def test_a_second_look_says_what_a_fresh_one_says():
    rng = np.random.default_rng(5)
    position, gradient = _field(_kinked)
    status = np.zeros((ROWS, COLS), dtype=np.uint8)
    look = None
    for turn in range(12):
        row, col = rng.integers(0, ROWS, 9), rng.integers(0, COLS, 9)
        position, gradient, status = position.copy(), gradient.copy(), status.copy()
        position[row[:5], col[:5]] += rng.normal(0, 0.5, (5, 2))
        gradient[row[3:6], col[3:6]] += rng.normal(0, 0.1, (3, 2, 2))
        status[row[5:7], col[5:7]] = PointStatus.NOT_CONVERGED
        status[row[7:], col[7:]] = PointStatus.OK
        fresh, _ = find_outliers(position, gradient, status, spacing=SPACING, floor=FLOOR)
        found, look = find_outliers(
            position, gradient, status, spacing=SPACING, floor=FLOOR, before=look
        )
        assert_array_equal(found, fresh)
        assert turn == 0 or fresh.any()
