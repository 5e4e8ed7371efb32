"""The deformed picture brought close to the reference."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.config import MorphConfig
from shapemorph.core.image import GreyImage
from shapemorph.core.laws import LawInputs
from shapemorph.core.matching import Matches, Warp
from shapemorph.methods.laws.identity import identity_warp
from shapemorph.methods.warping import warp_points
from shapemorph.stages.morph import morph_pictures

SHAPE = (70, 110)
SLOPE = np.array([[0.0, 1.2], [-0.9, 0.1]])  # a quarter turn and some stretch
SHIFT = np.array([8.0, 105.0])


def _matches():
    spacing, origin = 30.0, np.array([-60.0, -60.0])
    cols, rows = np.meshgrid(np.arange(9.0), np.arange(8.0))
    knots = origin + spacing * np.stack([cols, rows], axis=-1)
    warp = Warp(knots @ SLOPE.T + SHIFT, origin, spacing)
    nothing = np.zeros((0, 2))
    return Matches(nothing, nothing, warp, warp, {}, 0.0, 0.0, 0.0)


def test_the_morphed_picture_looks_like_the_reference(wave_pattern, pixel_grid):
    pattern, big = wave_pattern(7.0), (120, 130)
    material = (pixel_grid(big) - SHIFT) @ np.linalg.inv(SLOPE).T
    deformed = GreyImage(pattern(material).astype("f4"), np.ones(big, dtype=bool))
    reference = GreyImage(np.zeros(SHAPE, "f4"), np.ones(SHAPE, dtype=bool))
    found = morph_pictures(reference, deformed, _matches(), LawInputs(), MorphConfig())
    assert found.image.shape == SHAPE
    inner = found.image.mask.copy()
    inner[:6], inner[-6:], inner[:, :6], inner[:, -6:] = False, False, False, False
    assert inner.mean() > 0.6
    expected = pattern(pixel_grid(SHAPE))
    assert_allclose(found.image.grey[inner], expected[inner], atol=0.03)
    assert found.warp is not None


def test_identity_leaves_the_picture_alone(wave_pattern, pixel_grid):
    picture = GreyImage(wave_pattern()(pixel_grid(SHAPE)).astype("f4"), np.ones(SHAPE, dtype=bool))
    none = replace(_matches(), forward=None, backward=None)
    config = MorphConfig(law="identity")
    found = morph_pictures(picture, picture, none, LawInputs(), config)
    # the pictures agree with the law to a few hundredths of a pixel, and so does what is kept
    assert_allclose(found.image.grey[3:-3, 3:-3], picture.grey[3:-3, 3:-3], atol=0.02)


@pytest.mark.parametrize("shape", [(5, 5), (40, 900)])
def test_the_identity_warp_holds_beyond_the_picture(shape):
    points = np.array([[-5.0, -3.0], [shape[1] + 9.0, shape[0] + 4.0], [1.5, 2.25]])
    targets, gradient = warp_points(identity_warp(shape), points)
    assert_allclose(targets, points, atol=1e-9)
    assert_allclose(gradient, np.broadcast_to(np.eye(2), (3, 2, 2)), atol=1e-12)
