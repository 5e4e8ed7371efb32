"""What neighbours say about a point."""

import numpy as np
from numpy.testing import assert_allclose

from shapemorph.kernels.neighbours import predict_from_neighbours

SPACING = 4.0
SLOPE = np.array([[1.1, 0.2], [-0.3, 0.9]])


def _affine_grid(rows=6, cols=7):
    y, x = np.mgrid[:rows, :cols] * SPACING
    position = np.stack([x, y], axis=-1) @ SLOPE.T + [3.0, -2.0]
    return position, np.broadcast_to(SLOPE, (rows, cols, 2, 2)).copy()


def _predict(position, gradient, usable, queries, reach=2):
    queries = np.array(queries)
    number = len(queries)
    found, slope = np.zeros((number, 2)), np.zeros((number, 2, 2))
    spread, count = np.zeros(number), np.zeros(number, dtype=np.int64)
    predict_from_neighbours(
        position, gradient, usable, queries, SPACING, reach, found, slope, spread, count
    )
    return found, slope, spread, count


def test_an_affine_field_is_predicted_exactly_everywhere():
    position, gradient = _affine_grid()
    queries = np.argwhere(np.ones(position.shape[:2], dtype=bool))
    found, slope, spread, _ = _predict(position, gradient, np.ones((6, 7), dtype=bool), queries)
    assert_allclose(found, position.reshape(-1, 2), atol=1e-12)
    assert_allclose(slope, np.broadcast_to(SLOPE, slope.shape), atol=1e-12)
    assert_allclose(spread, 0, atol=1e-12)


def test_a_point_does_not_speak_for_itself_and_a_liar_is_outvoted():
    position, gradient = _affine_grid()
    right = position[2, 3].copy()
    position[2, 3] += 50.0
    position[1, 3] -= 20.0
    found, _, _, count = _predict(position, gradient, np.ones((6, 7), dtype=bool), [[2, 3]])
    assert_allclose(found[0], right, atol=1e-12)
    assert count[0] == 24


def test_two_neighbours_are_not_enough():
    position, gradient = _affine_grid()
    usable = np.zeros((6, 7), dtype=bool)
    usable[0, 0] = usable[0, 1] = True
    found, slope, spread, count = _predict(position, gradient, usable, [[1, 1]])
    assert np.isnan(found).all()
    assert np.isnan(slope).all()
    assert np.isnan(spread).all()
    assert count[0] == 2


def test_even_numbers_of_neighbours_meet_in_the_middle():
    position, gradient = _affine_grid()
    usable = np.zeros((6, 7), dtype=bool)
    for k, (row, col) in enumerate([(1, 1), (1, 3), (3, 1), (3, 3)]):
        usable[row, col] = True
        position[row, col, 0] += [0.0, 1.0, 2.0, 9.0][k]
    found, _, _, _ = _predict(position, gradient, usable, [[2, 2]])
    expected = _affine_grid()[0][2, 2] + [1.5, 0.0]
    assert_allclose(found[0], expected, atol=1e-12)
