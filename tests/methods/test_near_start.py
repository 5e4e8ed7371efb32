"""Near starts: found where they lead somewhere, refused where they would not."""

import numpy as np
import pytest

from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.methods.laws.identity import identity_warp
from shapemorph.methods.near_start import likeliest_start, near_start, start_from
from shapemorph.methods.speckle import speckle_size
from shapemorph.methods.subset_dic import SubsetSettings
from shapemorph.methods.synthetic.planar import Exposure, planar_speckle, take_picture
from shapemorph.methods.warping import warp_points

SHAPE = (220, 260)
SETTINGS = SubsetSettings(
    radius=10, order=1, tolerance=0.02, max_iterations=30, min_inside=0.5, max_drift=10.0
)


def picture(matrix=((1.0, 0.0), (0.0, 1.0)), shift=(0.0, 0.0), seed=3):
    back = np.linalg.inv(np.array(matrix))
    exposure = Exposure(gain=1.0, offset=0.0, slope=0.0, noise=1.0, seed=seed, blur=0.8)
    return take_picture(
        planar_speckle(diameter=5.0, seed=2), SHAPE, exposure,
        material_at=lambda p: (p - np.array(shift)) @ back.T,
        inside=lambda p: np.ones(p.shape[:-1], dtype=bool),
    )  # fmt: skip


def start(first, second):
    speckle = speckle_size(first.grey, first.mask)
    return near_start(first, second, speckle=lambda: speckle, settings=SETTINGS, min_zncc=0.7)


def test_a_small_motion_needs_no_features():
    assert start(picture(), picture(shift=(1.3, -0.8), seed=4)) is not None


@pytest.mark.parametrize("shift", [(17.3, -9.8), (-24.0, 21.0)])
def test_a_farther_shift_is_found_by_large_tiles(shift):
    matrix = np.array([[1.01, 0.004], [-0.003, 0.992]])
    warp = start(picture(), picture(matrix, shift, seed=4)).warp
    points = np.array([[60.0, 70.0], [150.0, 140.0]])
    targets, slope = warp_points(warp, points)
    np.testing.assert_allclose(targets, points @ matrix.T + shift, atol=0.1)
    np.testing.assert_allclose(slope[0], matrix, atol=2e-3)


@pytest.mark.parametrize(
    ("matrix", "shift"),
    [
        (((1.5, 0.2), (-0.15, 1.1)), (30.0, 20.0)),
        (((0.0, -1.0), (1.0, 0.0)), (240.0, 0.0)),
        (((1.0, 0.0), (0.0, 1.0)), (120.0, 90.0)),
    ],
)
def test_large_motion_is_left_to_features(matrix, shift):
    assert start(picture(), picture(matrix, shift, seed=4)) is None


def test_another_pattern_is_no_start():
    other = np.random.default_rng(1).random(SHAPE).astype(np.float32)
    assert start(picture(), GreyImage(other, np.ones(SHAPE, bool))) is None


def test_a_pattern_that_repeats_is_not_believed():
    rows, cols = np.mgrid[: SHAPE[0], : SHAPE[1]]
    dots = 0.5 + 0.2 * np.cos(2 * np.pi * cols / 16) * np.cos(2 * np.pi * rows / 16)
    still = GreyImage(dots.astype(np.float32), np.ones(SHAPE, bool))
    assert start(still, still) is None


def test_pictures_without_room_or_pattern_are_no_start():
    blank = GreyImage(np.full(SHAPE, 0.5, np.float32), np.ones(SHAPE, bool))
    assert start(blank, blank) is None
    small = GreyImage(np.full((12, 14), 0.5, np.float32), np.ones((12, 14), bool))
    assert start(small, small) is None


@pytest.mark.parametrize("shift", [(0.4, 0.2), (17.0, -9.0)])
def test_of_several_starts_the_one_is_taken_that_leads(shift):
    first, second = picture(), picture(shift=shift, seed=4)
    still = identity_warp(SHAPE)
    moved = Warp(still.coefficients + np.array([17.5, -9.5]), still.origin, still.spacing)
    begin = start_from(still, first, second, settings=SETTINGS)
    found = likeliest_start(begin, [still, moved], first.mask, settings=SETTINGS, min_zncc=0.7)
    assert found.warp is (moved if shift[0] > 10 else still)
    only = likeliest_start(begin, [moved], first.mask, settings=SETTINGS, min_zncc=0.7)
    assert only.warp is moved
