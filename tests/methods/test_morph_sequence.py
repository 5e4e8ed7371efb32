"""The morph sequence of an affine map, which a cubic warp holds exactly."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import ndimage

from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.methods.morph_sequence import morph_sequence, move_picture

MATRIX = np.array([[1.3, 0.15], [-0.1, 0.9]])
SHIFT = np.array([4.0, 9.0])


def _warp(matrix, shift):
    rows, columns = np.mgrid[-3:12, -3:14].astype(float)
    nodes = 15.0 * np.stack([columns, rows], axis=-1)
    return Warp(nodes @ matrix.T + shift, np.array([-45.0, -45.0]), 15.0)


def _inverse():
    inverse = np.linalg.inv(MATRIX)
    return _warp(inverse, -inverse @ SHIFT)


def _grey(x, y):
    """A smooth pattern of the material, far below the Nyquist frequency (period 16 px)."""
    return 0.5 + 0.2 * np.sin(0.39 * x + 0.2 * y) + 0.2 * np.cos(0.31 * y - 0.11 * x)


def _pictures():
    rows, columns = np.mgrid[0:90, 0:120].astype(float)
    reference = GreyImage(_grey(columns, rows).astype("f4"), np.ones((90, 120), bool))
    rows, columns = np.mgrid[0:110, 0:170].astype(float)
    material = (np.stack([columns, rows], -1) - SHIFT) @ np.linalg.inv(MATRIX).T
    x, y = material[..., 0], material[..., 1]
    mask = (x > 0) & (x < 119) & (y > 0) & (y < 89)
    return reference, GreyImage(np.where(mask, _grey(x, y), 0).astype("f4"), mask)


@pytest.mark.parametrize("fraction", [0.0, 1 / 6, 0.5, 1.0])
def test_a_moved_picture_shows_the_material_where_the_fraction_puts_it(fraction):
    reference, _ = _pictures()
    moved = move_picture(reference, _warp(MATRIX, SHIFT), fraction, (110, 170))
    part = np.eye(2) + fraction * (MATRIX - np.eye(2))
    rows, columns = np.mgrid[0:110, 0:170].astype(float)
    x, y = np.moveaxis(
        (np.stack([columns, rows], -1) - fraction * SHIFT) @ np.linalg.inv(part).T, -1, 0
    )
    deep = (x > 4) & (x < 115) & (y > 4) & (y < 85)
    assert moved.mask[deep].all()
    assert not moved.mask[(x < -1) | (x > 120) | (y < -1) | (y > 90)].any()
    # cubic spline error at a period of 14 px is below 1e-3 of an amplitude of 0.4
    assert_allclose(moved.grey[deep], _grey(x, y)[deep], atol=1e-3)


def test_both_middle_pictures_agree_and_the_ends_come_from_their_own_side():
    reference, deformed = _pictures()
    frames = list(morph_sequence(reference, deformed, _warp(MATRIX, SHIFT), _inverse(), images=6))
    assert len(frames) == 6
    # The deformed picture has a sharp rim of its own: compare two pixels inside it.
    both = ndimage.binary_erosion(frames[2].mask & frames[3].mask, iterations=5)
    assert both.sum() > 8000
    assert_allclose(frames[2].grey[both], frames[3].grey[both], atol=4e-3)
    first = move_picture(reference, _warp(MATRIX, SHIFT), 1 / 6, (110, 170))
    assert_allclose(frames[0].grey, first.grey)
    last = move_picture(deformed, _inverse(), 1 / 6, (110, 170))
    assert_allclose(frames[-1].grey, last.grey)


def test_no_images_is_an_empty_sequence():
    reference, deformed = _pictures()
    assert not list(morph_sequence(reference, deformed, _warp(MATRIX, SHIFT), _inverse(), images=0))
