"""Noise between two pictures of one state."""

import numpy as np
import pytest

from shapemorph.core.image import GreyImage
from shapemorph.methods.pair_noise import pair_noise
from shapemorph.methods.synthetic.planar import Exposure, planar_speckle, take_picture

SHAPE = (160, 200)


def picture(shift, noise, seed, gain=1.0):
    exposure = Exposure(gain=gain, offset=0.02, slope=0.03, noise=noise, seed=seed, blur=1.0)
    return take_picture(
        planar_speckle(diameter=6.0, seed=5), SHAPE, exposure,
        material_at=lambda p: p - shift, inside=lambda p: np.ones(p.shape[:-1], dtype=bool),
    )  # fmt: skip


@pytest.mark.parametrize("noise", [1.0, 3.0])
@pytest.mark.parametrize("shift", [[0.0, 0.0], [0.2, -0.15]])
def test_noise_is_found_in_spite_of_light_and_a_little_motion(noise, shift):
    first = picture(np.zeros(2), noise, 1)
    second = picture(np.array(shift), noise, 2, gain=1.1)
    rounding = 1 / np.sqrt(12)
    expected = np.hypot(noise, rounding) / 255
    assert pair_noise(first, second) == pytest.approx(expected, rel=0.06)


def test_pictures_that_moved_far_tell_nothing():
    assert np.isnan(pair_noise(picture(np.zeros(2), 1.0, 1), picture(np.array([3.0, 0]), 1.0, 2)))


def test_pictures_of_two_sizes_tell_nothing():
    first = picture(np.zeros(2), 1.0, 1)
    other = GreyImage(first.grey[:-2].copy(), first.mask[:-2].copy())
    assert np.isnan(pair_noise(first, other))
