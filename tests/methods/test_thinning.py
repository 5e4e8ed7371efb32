import numpy as np
import pytest

from shapemorph.methods.thinning import thinned_quads


def _grid(rows, columns, spacing=7):
    x, y = np.meshgrid(spacing * np.arange(1, columns + 1), spacing * np.arange(3, rows + 3))
    ids = np.arange(rows * columns).reshape(rows, columns)
    cells = np.stack([ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:], ids[:-1, :-1]], -1).reshape(-1, 4)
    return np.stack([x.ravel(), y.ravel()], axis=1).astype(float), cells


def _areas(cells, positions):
    """Signed area of each quad, by the shoelace formula."""
    x, y = np.moveaxis(positions[cells], 2, 0)
    return 0.5 * np.sum(x * np.roll(y, -1, 1) - y * np.roll(x, -1, 1), axis=1)


@pytest.mark.parametrize("most", [100_000, 700, 500, 40])
def test_area_and_orientation_stay(most):
    positions, cells = _grid(33, 47)
    middle = positions[cells].mean(axis=1)
    cells = cells[np.hypot(*(middle - [170, 120]).T) > 30]  # a hole
    thinned = thinned_quads(cells, positions, most=most)
    before, after = _areas(cells, positions), _areas(thinned, positions)
    assert (np.sign(after) == np.sign(before[0])).all()
    assert after.sum() == pytest.approx(before.sum(), rel=1e-12)
    assert len(thinned) <= max(most, 300)  # what the hole and the rim keep


def test_every_quad_is_covered_once():
    positions, cells = _grid(20, 20)
    cells = np.delete(cells, [5, 40, 41, 200], axis=0)
    thinned = thinned_quads(cells, positions, most=100)
    low, high = positions[thinned].min(axis=1), positions[thinned].max(axis=1)
    middle = positions[cells].mean(axis=1)
    inside = (middle[:, None] > low) & (middle[:, None] < high)
    assert (inside.all(axis=2).sum(axis=1) == 1).all()


def test_few_quads_are_left_alone():
    positions, cells = _grid(5, 6)
    assert thinned_quads(cells, positions, most=20) is cells


def test_a_large_grid_comes_down_to_what_is_asked_for():
    positions, cells = _grid(401, 401)
    thinned = thinned_quads(cells, positions, most=20_000)
    assert 5_000 < len(thinned) <= 20_000
