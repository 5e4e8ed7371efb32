"""Steps of a morph sequence of an affine map, where strain per step is a closed form."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.methods.morph_sequence import morph_sequence
from shapemorph.methods.sequence_steps import (
    follow_points,
    images_for_strain,
    neighbour_zncc,
    points_of,
)
from shapemorph.methods.sequence_turn import NO_TURN

MATRIX = np.array([[1.5, 0.1], [0.0, 0.8]])
SHIFT = np.array([4.0, 9.0])
SHAPE, BIG = (90, 120), (90, 200)


def _warp(matrix, shift):
    rows, columns = np.mgrid[-3:12, -3:18].astype(float)
    nodes = 15.0 * np.stack([columns, rows], axis=-1)
    return Warp(nodes @ matrix.T + shift, np.array([-45.0, -45.0]), 15.0)


def _warps(matrix=MATRIX):
    inverse = np.linalg.inv(matrix)
    return _warp(matrix, SHIFT), _warp(inverse, -inverse @ SHIFT)


def _points():
    rows, columns = np.mgrid[10:80:20, 10:110:20].astype(float)
    return np.stack([columns.ravel(), rows.ravel()], axis=-1)


def test_points_lie_on_straight_ways_and_both_middle_pictures_agree():
    points = _points()
    followed = follow_points(points, *_warps(), images=6)
    there = points @ MATRIX.T + SHIFT
    parts = np.array([0, 1, 2, 3, 3, 4, 5, 6]) / 6
    expected = points + parts[:, None, None] * (there - points)
    assert_allclose(followed.positions, expected, atol=1e-8)


@pytest.mark.parametrize("images", [2, 4, 10])
def test_the_strain_of_a_step_is_that_of_the_map_between_two_pictures(images):
    followed = follow_points(_points(), *_warps(), images=images)
    parts = [k / images for k in range(images // 2 + 1)]
    parts += parts[-1:] + [k / images for k in range(images // 2 + 1, images + 1)]
    maps = [np.eye(2) + part * (MATRIX - np.eye(2)) for part in parts]
    expected = [
        np.linalg.norm(after @ np.linalg.inv(before) - np.eye(2), 2)
        for before, after in pairwise(maps)
    ]
    assert_allclose(followed.strain, expected, atol=1e-9)
    assert followed.strain[images // 2] == pytest.approx(0.0, abs=1e-9)  # both are half-way


def test_no_picture_between_is_one_step_of_the_whole_strain():
    followed = follow_points(_points(), *_warps(), images=0)
    assert len(followed.positions) == 2
    assert_allclose(followed.strain, [np.linalg.norm(MATRIX - np.eye(2), 2)], atol=1e-9)


def test_as_few_pictures_as_keep_the_strain_of_a_step_small():
    images = images_for_strain(_points(), _warps(), NO_TURN, most_strain=0.1, most_images=24)
    steps = [
        follow_points(_points(), *_warps(), images=n).strain.max() for n in (images, images - 2)
    ]
    assert steps[0] <= 0.1 < steps[1]
    limits = {"most_strain": 0.1, "most_images": 24}
    assert images_for_strain(_points(), _warps(-np.eye(2)), NO_TURN, **limits) == 24
    assert images_for_strain(_points(), _warps(np.eye(2)), NO_TURN, **limits) == 2


def _pictures(wave_pattern, pixel_grid):
    pattern = wave_pattern(7.0)
    back = (pixel_grid(BIG) - SHIFT) @ np.linalg.inv(MATRIX).T
    mask = (back > 0).all(axis=-1) & (back < [119, 89]).all(axis=-1)
    return (
        GreyImage(pattern(pixel_grid(SHAPE)).astype("f4"), np.ones(SHAPE, bool)),
        GreyImage(np.where(mask, pattern(back), 0).astype("f4"), mask),
    )


def test_neighbours_look_alike_the_more_the_more_there_are(wave_pattern, pixel_grid):
    pictures = _pictures(wave_pattern, pixel_grid)
    least = []
    for images in (0, 2, 8):
        sequence = [
            pictures[0],
            *morph_sequence(*pictures, *_warps(), images=images),
            pictures[1],
        ]
        followed = follow_points(points_of(pictures[0]), *_warps(), images=images)
        zncc = neighbour_zncc(sequence, followed, subset_size=21)
        assert zncc.shape == (images + 1,)
        least.append(zncc.min())
        if images:
            assert zncc[images // 2] > 0.99  # both halves show the same half-way state
    assert least[0] < 0.85 < least[1] < least[2]
    assert least[2] > 0.95


def test_points_lie_on_the_mask():
    mask = np.zeros((50, 80), bool)
    mask[10:30, 40:60] = True
    points = points_of(GreyImage(np.zeros(mask.shape, "f4"), mask))
    column, row = points.astype(int).T
    assert len(points) > 10
    assert mask[row, column].all()
