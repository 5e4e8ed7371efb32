import numpy as np

from shapemorph.core.image import GreyImage
from shapemorph.methods.cameras.glare import without_glare


def picture():
    grey = np.full((200, 250), 0.5, np.float32)
    grey[60:75, 100:120] = 1.0
    grey[150, 40] = 1.0
    mask = np.ones(grey.shape, bool)
    mask[:, :10] = False
    return GreyImage(grey, mask)


def test_spots_and_their_halo_leave_the_mask_and_single_pixels_stay():
    found = without_glare(picture())
    assert not found.mask[58:77, 98:122].any()
    assert found.mask[150, 40]
    assert found.mask[50, 100]
    assert not found.mask[:, :10].any()
    assert found.mask.sum() > 0.95 * picture().mask.sum()


def test_pictures_without_glare_are_as_they_were():
    dull = GreyImage(np.full((50, 60), 0.9, np.float32), np.ones((50, 60), bool))
    assert without_glare(dull) is dull
