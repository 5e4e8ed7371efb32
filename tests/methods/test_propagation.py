"""Propagation from searched seeds over islands that move apart."""

import numpy as np
import pytest
from scipy.ndimage import binary_erosion

from shapemorph.core.image import GreyImage
from shapemorph.core.status import PointStatus
from shapemorph.methods.grid_correlation import Limits
from shapemorph.methods.paper_dic import SearchSettings
from shapemorph.methods.propagation import correlate_from_seeds
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import SubsetSettings, grid_points

SHAPE = (110, 200)
SETTINGS = SearchSettings(SubsetSettings(7, 1, 1e-3, 30, 0.5, 7.0), Limits(0.7, 0.15), 41)
MOVES = {"left": np.array([6.3, -4.6]), "right": np.array([-5.4, 3.7])}
STRETCH = np.array([[1.09, 0.03], [-0.02, 0.94]])  # of the left island: 5 px more at its ends


@pytest.fixture(scope="module")
def outcome(wave_pattern, pixel_grid):
    """Grid, its matches and true positions of two islands."""
    pattern, pixels = wave_pattern(), pixel_grid(SHAPE)
    masks = {"left": np.zeros(SHAPE, dtype=bool), "right": np.zeros(SHAPE, dtype=bool)}
    masks["left"][15:95, 15:105], masks["right"][40:75, 140:175] = True, True
    slopes, middle = {"left": STRETCH, "right": np.eye(2)}, np.array([60.0, 55.0])
    grey, shown = np.full(SHAPE, 0.5), np.zeros(SHAPE, dtype=bool)
    grid = grid_points(masks["left"] | masks["right"], spacing=5)
    truth = np.full(grid.points.shape, np.nan)
    for name, mask in masks.items():
        back = (pixels - MOVES[name] - middle) @ np.linalg.inv(slopes[name]).T + middle
        near = np.rint(back).astype(int)
        inside = ((near >= 0) & (near < SHAPE[::-1])).all(axis=-1)
        inside[inside] = mask[near[inside][:, 1], near[inside][:, 0]]
        grey[inside], shown[inside] = pattern(back)[inside], True
        own = mask[grid.points[..., 1], grid.points[..., 0]]
        truth[own] = ((grid.points - middle) @ slopes[name].T + middle + MOVES[name])[own]
    still = GreyImage(pattern(pixels).astype("f4"), masks["left"] | masks["right"])
    moved = GreyImage(grey.astype("f4"), shown)
    pad = SETTINGS.subset.pad
    reference = prepare_reference(still, allowed=None, pad=pad)
    deformed = prepare_deformed(moved, pad=pad)
    found = correlate_from_seeds(reference, deformed, moved, grid, settings=SETTINGS)
    return grid, found, truth


def test_both_islands_are_found_whole(outcome):
    grid, found, _ = outcome
    few = found.status == PointStatus.LOW_CONTRAST  # pixels, in the corners of the islands
    assert few.sum() < 0.05 * grid.inside.sum()
    assert found.ok[grid.inside & ~few].all()
    assert found.ok[binary_erosion(grid.inside)].all()
    assert (found.status[~grid.inside] == PointStatus.OUTSIDE_MASK).all()


def test_what_is_found_is_right(outcome):
    _, found, truth = outcome
    error = np.abs(found.position - truth)[found.ok]
    assert error.max() < 0.1
    assert np.sqrt((error**2).mean()) < 0.01
