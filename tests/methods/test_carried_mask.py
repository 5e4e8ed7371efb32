import numpy as np
import pytest

from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.methods.carried_mask import carried_mask, limit_to_carried
from shapemorph.methods.laws.identity import identity_warp

SHAPE, LATER = (120, 150), (200, 220)


def affine_warp(matrix, shift):
    warp = identity_warp(SHAPE)
    return Warp(warp.coefficients @ np.array(matrix).T + shift, warp.origin, warp.spacing)


@pytest.fixture
def ring():
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    radius = np.hypot(x - 70, y - 60)
    return (radius < 45) & (radius > 15)


def test_a_ring_is_carried_with_its_hole(ring):
    matrix, shift = np.array([[1.3, 0.3], [-0.2, 1.1]]), np.array([5.0, 40.0])
    found = carried_mask(ring, affine_warp(matrix, shift), LATER)
    y, x = np.mgrid[: LATER[0], : LATER[1]]
    back = (np.stack([x, y], axis=-1) - shift) @ np.linalg.inv(matrix).T
    radius = np.hypot(back[..., 0] - 70, back[..., 1] - 60)
    assert found[(radius < 43.5) & (radius > 16.5)].all()
    assert not found[(radius > 46.5) | (radius < 13.5)].any()


def test_what_leaves_the_picture_is_cut_off(ring):
    found = carried_mask(ring, affine_warp(np.eye(2), [-60.0, -30.0]), SHAPE)
    np.testing.assert_array_equal(found[:80, 1:80], ring[30:110, 61:140])
    assert not found[:, 100:].any()


def test_no_motion_leaves_a_mask_as_it_is(ring):
    ring[3:7, 3:7] = True  # a piece of its own
    np.testing.assert_array_equal(carried_mask(ring, identity_warp(SHAPE), SHAPE), ring)


def test_an_empty_mask_stays_empty():
    nothing = np.zeros(SHAPE, dtype=bool)
    assert not carried_mask(nothing, identity_warp(SHAPE), SHAPE).any()


def test_what_the_later_picture_does_not_show_does_not_count(ring):
    grey = np.zeros(SHAPE, dtype=np.float32)
    shown = np.ones(SHAPE, dtype=bool)
    shown[:60] = False
    first, later = GreyImage(grey, ring), GreyImage(grey, shown)
    found = limit_to_carried(later, first, identity_warp(SHAPE))
    np.testing.assert_array_equal(found.mask, ring & shown)
    whole = GreyImage(grey, np.ones_like(ring))
    assert limit_to_carried(later, whole, identity_warp(SHAPE)) is later
