"""The paper's correlation against fields that are known exactly."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from shapemorph.core.image import GreyImage
from shapemorph.core.status import PointStatus
from shapemorph.methods.grid_correlation import Limits
from shapemorph.methods.paper_dic import SearchSettings, correlate_like_paper, first_guesses
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import PointGrid, SubsetSettings, grid_points

SHAPE = (130, 150)
CENTRE = np.array([75.0, 65.0])
SETTINGS = SearchSettings(SubsetSettings(10, 1, 0.1, 30, 0.5, 10.0), Limits(0.7, 0.15), 41)


def _correlate(wave_pattern, pixel_grid, slope, shift, noise=2 / 255):
    """Points of an affine field, with their true positions."""
    pattern, pixels = wave_pattern(), pixel_grid(SHAPE)
    rng, full = np.random.default_rng(1), np.ones(SHAPE, dtype=bool)
    back = (pixels - CENTRE - shift) @ np.linalg.inv(slope).T + CENTRE
    greys = [pattern(at) + rng.normal(0, noise, SHAPE) for at in (pixels, back)]
    still, moved = (GreyImage(grey.astype("f4"), full) for grey in greys)
    pad = SETTINGS.subset.pad
    reference = prepare_reference(still, allowed=None, pad=pad)
    deformed = prepare_deformed(moved, pad=pad)
    grid = grid_points(full, spacing=8)
    found = correlate_like_paper(reference, deformed, moved, grid, settings=SETTINGS)
    return grid, found, (grid.points - CENTRE) @ slope.T + CENTRE + shift


@pytest.mark.parametrize(
    ("slope", "shift"),
    [
        (np.eye(2), [0.3, -0.4]),
        (np.eye(2), [7.5, 6.2]),
        (np.array([[1.03, 0.01], [-0.02, 0.98]]), [1.3, -2.6]),
        (np.array([[0.97, -0.06], [0.06, 1.02]]), [-0.4, 0.7]),
    ],
)
def test_affine_fields_are_found_to_a_tenth_of_a_pixel(slope, shift, wave_pattern, pixel_grid):
    grid, found, truth = _correlate(wave_pattern, pixel_grid, slope, np.array(shift))
    error = np.abs(found.position - truth)
    assert error[found.ok].max() < 0.1
    assert_allclose(found.gradient[found.ok].mean(axis=0), slope, atol=3e-3)
    reach = np.abs(slope - np.eye(2)).sum(axis=1) * 11 + 11  # of a subset, and the rim
    room = (truth > reach).all(axis=-1) & (truth < np.array(SHAPE[::-1]) - 1 - reach).all(axis=-1)
    room &= (grid.points > 11).all(axis=-1) & (grid.points < np.array(SHAPE[::-1]) - 12).all(-1)
    assert room.sum() > 80
    assert found.ok[room].mean() > 0.98


def test_a_motion_beyond_the_search_window_is_not_found(wave_pattern, pixel_grid):
    _, found, _ = _correlate(wave_pattern, pixel_grid, np.eye(2), np.array([16.0, 0.0]))
    assert not found.ok.any()
    assert (found.status == PointStatus.NOT_SEEDED).mean() > 0.5


def test_first_guesses_are_exact_for_an_affine_field():
    grid = grid_points(np.ones((41, 51), dtype=bool), spacing=10)
    slope = np.array([[1.1, 0.2], [-0.1, 0.9]])
    truth = grid.points @ slope.T + [3.0, -2.0]
    usable = np.ones(grid.inside.shape, dtype=bool)
    usable[1:, 2] = usable[0, 0] = False
    position, gradient, known = first_guesses(grid, truth - grid.points, usable)
    assert known.all()
    assert_allclose(position, truth, atol=1e-9)
    assert_allclose(gradient, np.broadcast_to(slope, gradient.shape), atol=1e-9)


def test_two_neighbours_or_three_on_a_line_tell_nothing():
    points = np.stack(np.meshgrid(np.arange(4), np.arange(3)), axis=-1) * 5
    usable = np.zeros((3, 4), dtype=bool)
    usable[1, :3] = True
    grid = PointGrid(points, usable, 5)
    _, _, known = first_guesses(grid, np.zeros((3, 4, 2)), usable)
    assert_array_equal(known, False)
