"""Light that varies over one picture only."""

import numpy as np
import pytest

from shapemorph.core.image import GreyImage
from shapemorph.methods.light import uneven_light

SHAPE = (240, 320)


def speckle(seed=0):
    from scipy.ndimage import gaussian_filter

    noise = gaussian_filter(np.random.default_rng(seed).normal(size=SHAPE), 2.0)
    return (0.5 + 0.15 * noise / noise.std()).astype(np.float32)


def picture(grey, mask=None):
    return GreyImage(grey.astype(np.float32), np.ones(SHAPE, dtype=bool) if mask is None else mask)


def gain_field():
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return 0.8 + 0.25 * x / SHAPE[1] - 0.2 * (y / SHAPE[0]) ** 2


def test_smooth_light_is_taken_off_up_to_one_gain_and_one_offset():
    grey, light = speckle(), gain_field()
    found = uneven_light(picture(grey), picture(light * grey + 0.04))
    lit = found.taken_off(picture(light * grey)).grey
    ratio = lit / grey
    assert np.ptp(ratio) / ratio.mean() < 0.002
    assert np.ptp(light) / light.mean() > 0.3


def test_glare_and_what_is_masked_do_not_bend_the_light():
    grey, light = speckle(), gain_field()
    after = light * grey
    after[40:90, 50:120] = 1.0
    mask = np.ones(SHAPE, dtype=bool)
    mask[:, 260:] = False
    after[:, 260:] = 0.0
    found = uneven_light(picture(grey), picture(after, mask))
    ratio = found.taken_off(picture(light * grey)).grey[:, :260] / grey[:, :260]
    assert np.ptp(ratio) / ratio.mean() < 0.01


@pytest.mark.parametrize("shift", [0.0, 2.0])
def test_even_light_stays_with_noise_and_where_the_pattern_is_a_little_off(shift):
    rng = np.random.default_rng(3)
    grey = speckle()
    after = 0.7 * np.roll(grey, int(shift), axis=1) + 0.1 + 0.01 * rng.normal(size=SHAPE)
    assert uneven_light(picture(grey), picture(after)) is None


def test_too_little_in_common_tells_nothing():
    mask = np.zeros(SHAPE, dtype=bool)
    mask[:30, :30] = True
    grey = speckle()
    assert uneven_light(picture(grey), picture(gain_field() * grey, mask)) is None


def test_a_picture_of_another_size_takes_the_light_too():
    grey, light = speckle(), gain_field()
    found = uneven_light(picture(grey), picture(light * grey))
    small, large = np.ones((200, 300), np.float32), np.ones((260, 400), np.float32)
    whole = found.taken_off(picture(np.ones(SHAPE))).grey
    for other in (small, large):
        lit = found.taken_off(GreyImage(other, other > 0)).grey
        height, width = min(other.shape[0], SHAPE[0]), min(other.shape[1], SHAPE[1])
        np.testing.assert_array_equal(lit[:height, :width], whole[:height, :width])
        assert lit.shape == other.shape
        assert np.isfinite(lit).all()
