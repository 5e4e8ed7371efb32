"""Slopes, padding and pixels that count."""

import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from shapemorph.core.image import GreyImage
from shapemorph.methods.spline_pictures import (
    LANES,
    extend_grey,
    prepare_deformed,
    prepare_reference,
    shrink,
)

SHAPE = (40, 56)


def _wave(points):
    x, y = points[..., 0], points[..., 1]
    return 0.5 + 0.2 * np.sin(0.3 * x + 0.17 * y)


def test_slopes_are_those_of_the_pattern(pixel_grid):
    pixels = pixel_grid(SHAPE)
    picture = GreyImage(_wave(pixels).astype("f4"), np.ones(SHAPE, dtype=bool))
    found = prepare_reference(picture, allowed=None, pad=7)
    inner = (slice(7 + 8, 7 + 32), slice(7 + 8, 7 + 48))
    phase = (0.3 * pixels[..., 0] + 0.17 * pixels[..., 1])[8:32, 8:48]
    assert_allclose(found.planes[0][inner], _wave(pixels)[8:32, 8:48], atol=1e-6)
    assert_allclose(found.planes[1][inner], 0.06 * np.cos(phase), atol=5e-5)
    assert_allclose(found.planes[2][inner], 0.034 * np.cos(phase), atol=5e-5)


def test_slopes_of_a_quintic_spline_are_closer(pixel_grid):
    pixels = pixel_grid(SHAPE)
    phase = 1.1 * pixels[..., 0]
    picture = GreyImage((0.5 + 0.2 * np.sin(phase)).astype("f4"), np.ones(SHAPE, dtype=bool))
    inner = (slice(7 + 8, 7 + 32), slice(7 + 12, 7 + 44))
    truth = 0.22 * np.cos(phase)[8:32, 12:44]
    errors = []
    for degree in (3, 5):
        found = prepare_reference(picture, allowed=None, pad=7, degree=degree)
        errors.append(np.abs(found.planes[1][inner] - truth).max())
    cubic_error = abs(3 * np.sin(1.1) / (2 + np.cos(1.1)) / 1.1 - 1) * 0.22
    assert_allclose(errors[0], cubic_error, rtol=0.01)
    assert errors[1] < 0.15 * errors[0]


def test_counts_are_sums_of_the_pixels_inside():
    mask = np.zeros(SHAPE, dtype=bool)
    mask[5:30, 10:50] = True
    picture = GreyImage(np.zeros(SHAPE, dtype="f4"), mask)
    found = prepare_deformed(picture, pad=3)
    assert found.counts.shape == (SHAPE[0] + 2 * 3 + 1, SHAPE[1] + 2 * 3 + LANES + 1)
    assert found.counts[-1, -1] == 23 * 38  # the rim does not count
    assert found.counts[3 + 10, 3 + 20] == 4 * 9


def test_the_rim_of_mask_and_picture_does_not_count():
    mask = np.ones((5, 6), dtype=bool)
    mask[2, 3] = False
    expected = np.zeros((5, 6), dtype=bool)
    expected[1:4, 1] = True
    assert_array_equal(shrink(mask), expected)


def test_only_allowed_pixels_count():
    allowed = np.zeros(SHAPE, dtype=bool)
    allowed[10:20, 10:20] = True
    picture = GreyImage(np.zeros(SHAPE, dtype="f4"), np.ones(SHAPE, dtype=bool))
    assert prepare_reference(picture, allowed=allowed, pad=2).inside.sum() == 100


def test_grey_outside_the_mask_has_no_say(pixel_grid):
    mask = np.zeros(SHAPE, dtype=bool)
    mask[8:30, 9:41] = True
    grey = _wave(pixel_grid(SHAPE)).astype("f4")
    spoiled = np.where(mask, grey, np.float32(77.0))
    extended = extend_grey(GreyImage(spoiled, mask))
    assert_array_equal(extended[mask], grey[mask])
    assert extended.max() < 0.8
    assert abs(extended[7, 20] - grey[8, 19:22].mean()) < 1e-6


def test_the_spline_is_mirrored_at_the_border(pixel_grid):
    grey = _wave(pixel_grid(SHAPE)).astype("f4")
    found = prepare_deformed(GreyImage(grey, np.ones(SHAPE, dtype=bool)), pad=4)
    assert_array_equal(found.coefficients[3, 10:20], found.coefficients[5, 10:20])
    last = 4 + SHAPE[1] - 1
    assert_array_equal(found.coefficients[10:20, last + 2], found.coefficients[10:20, last - 2])
