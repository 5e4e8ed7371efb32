import numpy as np
import pytest

from shapemorph.methods.cameras.dots import Dots
from shapemorph.methods.cameras.lattice import index_dots

ROWS, COLUMNS = 7, 9


def seen_obliquely(extra=()):
    """A flat lattice in perspective, turned, in no order; other dots at the end."""
    rows, columns = np.divmod(np.random.default_rng(3).permutation(ROWS * COLUMNS), COLUMNS)
    depth = 1.0 + 0.05 * columns + 0.02 * rows
    x, y = 40.0 * columns / depth, 40.0 * rows / depth
    turned = np.stack([0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y], axis=1)
    centres = np.concatenate([turned, np.reshape(extra, (-1, 2))]) + 300.0
    return Dots(centres, np.full(len(centres), 100.0)), np.stack([rows, columns], axis=1)


def test_steps_are_rows_and_columns_but_for_turn_and_start():
    dots, places = seen_obliquely()
    numbers, steps = index_dots(dots)[0]
    assert sorted(numbers) == list(range(ROWS * COLUMNS))
    design = np.column_stack([places[numbers], np.ones(len(numbers))])
    turn, left = np.linalg.lstsq(design, steps.astype(float))[:2]
    assert np.abs(left).max() < 1e-20
    np.testing.assert_allclose(np.abs(turn[:2]).sum(axis=0), 1.0, atol=1e-9)
    assert abs(np.linalg.det(turn[:2])) == pytest.approx(1.0)


def test_a_dot_between_rows_is_no_part_of_them():
    dots, _ = seen_obliquely(extra=[(15.0, 40.0), (-400.0, 500.0)])
    numbers, _ = index_dots(dots)[0]
    assert sorted(numbers) == list(range(ROWS * COLUMNS))


@pytest.mark.parametrize("count", [0, 3])
def test_too_few_dots_are_no_lattice(count):
    dots, _ = seen_obliquely()
    assert index_dots(Dots(dots.centres[:count], dots.areas[:count])) == []
