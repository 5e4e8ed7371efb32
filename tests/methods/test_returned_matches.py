"""Matches in doubt that lead back to their start, and such that do not."""

from dataclasses import replace

import numpy as np

from shapemorph.core.image import GreyImage
from shapemorph.core.status import PointStatus
from shapemorph.methods.grid_correlation import Limits, correlate_grid
from shapemorph.methods.returned_matches import doubtful_matches, lost_on_return
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import SubsetSettings, grid_points

SHAPE = (110, 130)
SETTINGS = SubsetSettings(8, 1, 1e-3, 30, 0.5, 8.0)
SHIFT = np.array([0.7, -1.4])


def _matched(wave_pattern, pixel_grid):
    """A grid of good matches, and the pictures the other way round."""
    pattern, pixels, whole = wave_pattern(), pixel_grid(SHAPE), np.ones(SHAPE, dtype=bool)
    first, second = (GreyImage(pattern(at).astype("f4"), whole) for at in (pixels, pixels - SHIFT))
    grid = grid_points(whole, spacing=10)
    found = correlate_grid(
        prepare_reference(first, allowed=None, pad=SETTINGS.pad),
        prepare_deformed(second, pad=SETTINGS.pad),
        grid,
        settings=SETTINGS,
        limits=Limits(0.7, 0.15),
    )
    calls = []

    def backwards():
        calls.append(1)
        return (
            prepare_reference(second, allowed=None, pad=SETTINGS.pad),
            prepare_deformed(first, pad=SETTINGS.pad),
        )

    return grid, found, backwards, calls


def _lost(grid, found, backwards):
    noise = np.full(found.status.shape, 0.005)
    return lost_on_return(backwards, grid, found, noise, settings=SETTINGS)


def test_without_doubt_nothing_is_matched_back(wave_pattern, pixel_grid):
    grid, found, backwards, calls = _matched(wave_pattern, pixel_grid)
    assert found.ok.mean() > 0.9
    assert not doubtful_matches(found).any()
    assert not _lost(grid, found, backwards).any()
    assert calls == []


def test_only_what_does_not_return_is_lost(wave_pattern, pixel_grid):
    grid, found, backwards, calls = _matched(wave_pattern, pixel_grid)
    zncc, position = found.zncc.copy(), found.position.copy()
    right, wrong = [(4, 4), (6, 8)], [(3, 7), (7, 3)]
    for place in right + wrong:
        zncc[place] = 0.8
    for place in wrong:
        position[place] += [1.6, 0.9]
    doubted = replace(found, zncc=zncc, position=position)
    assert set(map(tuple, np.argwhere(doubtful_matches(doubted)).tolist())) == set(right + wrong)
    lost = _lost(grid, doubted, backwards)
    assert set(map(tuple, np.argwhere(lost).tolist())) == set(wrong)
    assert len(calls) == 1


def test_points_beside_a_failure_are_in_doubt(wave_pattern, pixel_grid):
    grid, found, backwards, _ = _matched(wave_pattern, pixel_grid)
    status = found.status.copy()
    status[5, 5] = PointStatus.NOT_CONVERGED
    doubted = replace(found, status=status)
    doubtful = doubtful_matches(doubted)
    assert doubtful.sum() == 8
    assert doubtful[4:7, 4:7].sum() == 8
    assert not _lost(grid, doubted, backwards).any()
