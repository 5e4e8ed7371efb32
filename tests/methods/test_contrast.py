import numpy as np
from numpy.testing import assert_allclose

from shapemorph.core.image import GreyImage
from shapemorph.methods.contrast import byte_picture, even_contrast

RNG = np.random.default_rng(0)
GREY = (0.5 + 0.1 * RNG.normal(size=(80, 110))).astype(np.float32)
EVERYWHERE = np.ones(GREY.shape, bool)


def test_gain_offset_and_slope_of_light_disappear():
    slope = np.linspace(0, 0.3, 110, dtype=np.float32)
    plain = even_contrast(GreyImage(GREY, EVERYWHERE), window=25).values
    lit = even_contrast(GreyImage(0.6 * GREY + slope, EVERYWHERE), window=25).values
    # the slope adds (0.3 / 110)^2 (25^2 - 1) / 12 to a local variance of 0.06^2: 10 %
    assert_allclose(lit[13:-13, 13:-13], plain[13:-13, 13:-13], atol=0.2, rtol=0.1)


def test_local_mean_is_zero_and_local_contrast_one():
    values = even_contrast(GreyImage(GREY, EVERYWHERE), window=25).values
    assert abs(values.mean()) < 0.02
    assert_allclose(values.std(), 1.0, atol=0.03)


def test_what_lies_outside_the_mask_has_no_influence():
    mask = EVERYWHERE.copy()
    mask[:, 60:] = False
    other = GREY.copy()
    other[:, 60:] = 7.0
    one, two = (even_contrast(GreyImage(grey, mask), window=25) for grey in (GREY, other))
    assert_allclose(one.values, two.values, atol=1e-6)
    assert not two.values[:, 60:].any()
    assert_allclose(two.values[:, :60].std(), 1.0, atol=0.05)


def test_faint_part_is_not_blown_up_to_full_contrast():
    grey = GREY.copy()
    grey[:, 60:] = 0.5 + 0.002 * RNG.normal(size=(80, 50))
    values = even_contrast(GreyImage(grey, EVERYWHERE), window=25).values
    assert values[:, 80:].std() < 0.3


def test_blank_and_empty_pictures_have_no_contrast():
    blank = even_contrast(GreyImage(np.full_like(GREY, 0.4), EVERYWHERE), window=25)
    empty = even_contrast(GreyImage(GREY, ~EVERYWHERE), window=25)
    assert blank.contrast < 1e-4
    assert empty.contrast == 0
    assert np.isfinite(blank.values).all()
    assert not empty.values.any()


def test_byte_picture_is_centred_and_clipped():
    levels = byte_picture(np.array([[0.0, 1.0, -9.0, 9.0]], np.float32))
    assert levels.tolist() == [[128, 168, 0, 255]]


def test_light_is_evened_up_to_the_rim_of_the_mask():
    mask = EVERYWHERE.copy()
    mask[:, 60:] = False
    lit = GREY + np.where(np.arange(110) < 30, 0.0, 0.5).astype(np.float32)
    values = even_contrast(GreyImage(lit, mask), window=25).values
    # the window sees only the bright side here: its own mean is all there is to subtract
    assert abs(values[:, 54:60].mean()) < 0.1
