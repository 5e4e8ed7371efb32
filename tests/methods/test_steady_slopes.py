"""Uncertain subsets with the slope of those beside them."""

from dataclasses import replace

import numpy as np

from shapemorph.core.image import GreyImage
from shapemorph.methods.correlation_noise import displacement_covariance
from shapemorph.methods.grid_correlation import empty_matches, merged_matches
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.steady_slopes import stands_out, steady_slopes
from shapemorph.methods.subset_dic import (
    SubsetSettings,
    affine_starts,
    grid_points,
    match_points,
)

SHAPE = (150, 150)
SETTINGS = SubsetSettings(10, 1, 1e-3, 40, 0.45, 10.0)
SLOPE = np.array([[1.01, 0.004], [-0.006, 0.995]])
CENTRE = np.array([75.0, 75.0])


def _forward(points):
    return (points - CENTRE) @ SLOPE.T + CENTRE + [0.4, -0.3]


def _run(pattern, pixels, seed):
    """Matches of an affine motion, with noise, up to the rim; before and after."""
    rng, whole = np.random.default_rng(seed), np.ones(SHAPE, dtype=bool)
    back = (pixels - CENTRE - [0.4, -0.3]) @ np.linalg.inv(SLOPE).T + CENTRE
    first, second = (
        GreyImage((pattern(at) + rng.normal(0, 2 / 255, SHAPE)).astype("f4"), whole)
        for at in (pixels, back)
    )
    source = prepare_reference(first, allowed=None, pad=SETTINGS.pad)
    target = prepare_deformed(second, pad=SETTINGS.pad)
    grid = grid_points(whole, spacing=10)
    at = grid.points[grid.inside]
    slopes = np.broadcast_to(np.eye(2), (len(at), 2, 2))
    starts = affine_starts(at, np.rint(_forward(at.astype(float))), slopes)
    matches = match_points(source, target, at, starts, settings=SETTINGS)
    found = merged_matches(empty_matches(grid), matches, np.argwhere(grid.inside))
    pictures = source, target
    covariance = displacement_covariance(
        *pictures, grid.points, found.warps, found.ok, settings=SETTINGS
    )
    steady, least = steady_slopes(*pictures, grid, found, covariance, settings=SETTINGS)
    return pictures, grid, (found, covariance), (steady, least)


def _error(grid, found):
    return found.position - _forward(grid.points.astype(float))


def test_cut_subsets_are_closer_and_as_uncertain_as_told(wave_pattern, pixel_grid):
    before, after, told = [], [], []
    for seed in range(6):
        _, grid, (found, _), (steady, least) = _run(wave_pattern(), pixel_grid(SHAPE), seed)
        changed = (steady.position != found.position).any(axis=-1)
        assert 0.05 < changed.mean() < 0.5
        before.append(_error(grid, found)[changed])
        after.append(_error(grid, steady)[changed])
        told.append(np.diagonal(least, axis1=-2, axis2=-1)[changed])
    rms = [np.sqrt((np.concatenate(each) ** 2).mean()) for each in (before, after)]
    assert rms[1] < 0.8 * rms[0]
    assert 0.7 < rms[1] / np.sqrt(np.concatenate(told).mean()) < 1.1


def test_certain_points_stay_bit_for_bit(wave_pattern, pixel_grid):
    _, _, (found, covariance), (steady, least) = _run(wave_pattern(), pixel_grid(SHAPE), 0)
    certain = found.ok & ~stands_out(covariance, by=1.2)
    assert certain.sum() > 50
    assert (steady.position[certain] == found.position[certain]).all()
    assert (least[certain] == covariance[certain]).all()


def test_a_slope_that_does_change_is_left_alone(wave_pattern, pixel_grid):
    pictures, grid, (found, covariance), _ = _run(wave_pattern(), pixel_grid(SHAPE), 0)
    doubted = covariance.copy()
    doubted[7, 7] *= 4.0
    other = np.array(found.gradient)
    other[4:11, 4:11] = np.eye(2) * 1.2
    other[7, 7] = found.gradient[7, 7]
    told = replace(found, gradient=other)
    steady, least = steady_slopes(*pictures, grid, told, doubted, settings=SETTINGS)
    assert (steady.position[7, 7] == found.position[7, 7]).all()
    assert (least[7, 7] == doubted[7, 7]).all()


def test_what_stands_out_is_told_from_the_usual():
    covariance = np.broadcast_to(1e-4 * np.eye(2), (5, 6, 2, 2)).copy()
    covariance[2, 3] *= 2.4
    covariance[1, 1] *= 2.0
    covariance[0, 0] = np.nan
    assert np.argwhere(stands_out(covariance)).tolist() == [[2, 3]]
    assert not stands_out(np.full((2, 2, 2, 2), np.nan)).any()
