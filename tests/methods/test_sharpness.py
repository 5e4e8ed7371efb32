import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from shapemorph.core.image import GreyImage
from shapemorph.methods.sharpness import blurred, missing_blur
from shapemorph.methods.synthetic.planar import planar_speckle


def picture(*, mask=None, sigma=(0.0, 0.0), noise=0.0, seed=0):
    """Speckle of 5 px, blurred by `sigma` (rows, columns), px."""
    rows, cols = np.mgrid[0:320, 0:320].astype(np.float64)
    grey = 0.5 + 0.15 * planar_speckle(diameter=5.0, seed=3).at(np.stack([cols, rows], axis=-1))
    grey = gaussian_filter(grey, sigma) + 0.0004 * cols
    grey += noise * np.random.default_rng(seed).normal(size=grey.shape)
    return GreyImage(grey.astype(np.float32), np.ones(grey.shape, bool) if mask is None else mask)


@pytest.mark.parametrize("sigma", [(2.0, 2.0), (1.2, 1.2), (0.0, 2.5)])
def test_the_blur_that_one_picture_lacks_is_found(sigma):
    sharp, soft = picture(noise=0.005), picture(sigma=sigma, noise=0.005, seed=1)
    found = missing_blur(sharp, soft)
    np.testing.assert_allclose(found.reference, np.diag(np.square(sigma[::-1])), atol=0.6)
    assert not found.deformed.any()
    other_way = missing_blur(soft, sharp)
    np.testing.assert_allclose(other_way.deformed, found.reference, atol=1e-9)


def test_each_may_be_softer_along_one_direction():
    found = missing_blur(picture(sigma=(0.0, 2.0)), picture(sigma=(1.5, 0.0)))
    np.testing.assert_allclose(found.reference, np.diag([0.0, 2.25]), atol=0.4)
    np.testing.assert_allclose(found.deformed, np.diag([4.0, 0.0]), atol=0.4)


def test_a_slight_blur_along_one_direction_is_found():
    found = missing_blur(picture(noise=0.01), picture(sigma=(0.0, 0.5), noise=0.01, seed=1))
    np.testing.assert_allclose(found.reference, np.diag([0.25, 0.0]), atol=0.05)
    assert not found.deformed.any()


def test_equally_sharp_pictures_stay_as_they_are():
    assert not missing_blur(picture(noise=0.01), picture(noise=0.03, seed=1))
    assert not missing_blur(picture(), picture(sigma=(0.4, 0.4)))


def test_without_enough_tiles_nothing_is_claimed():
    mask = np.zeros((320, 320), dtype=bool)
    mask[:100, :100] = True
    assert not missing_blur(picture(mask=mask), picture(mask=mask, sigma=(2.0, 2.0)))


def test_a_blur_is_found_with_little_scatter_where_a_mask_leaves_few_tiles():
    shown = np.hypot(*np.mgrid[-160:160, -160:160])
    found = [
        missing_blur(
            picture(noise=0.01, mask=shown < radius),
            picture(sigma=(0.7, 0.7), noise=0.01, seed=1, mask=shown < radius),
        ).reference
        for radius in (120.0, 130.0, 140.0, 150.0)
    ]
    assert np.ptp(found, axis=0).max() < 0.06  # px^2


def test_a_blur_takes_nothing_from_outside_the_mask():
    mask = np.zeros((320, 320), dtype=bool)
    mask[50:270, 40:280] = True
    grey = np.where(mask, np.float32(0.4), np.float32(1.0))
    soft = blurred(GreyImage(grey, mask), np.array([[4.0, 1.0], [1.0, 3.0]]))
    np.testing.assert_allclose(soft.grey[mask], 0.4, atol=1e-5)
    whole = np.ones_like(mask)
    wide = blurred(GreyImage(picture().grey, whole), np.diag([4.0, 4.0])).grey
    expected = gaussian_filter(picture().grey, 2.0, mode="nearest")
    np.testing.assert_allclose(wide, expected, atol=2e-3)
