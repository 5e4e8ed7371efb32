"""The measured part of a picture, carried into a later one."""

import numpy as np

from shapemorph.core.arrays import Bools
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.methods.warp_renewal import continue_warp

FRACTION_BITS = 4  # outlines are drawn to a sixteenth of a pixel


def limit_to_carried(picture: GreyImage, first: GreyImage, warp: Warp) -> GreyImage:
    """Limit a picture to where a warp has carried the mask of the first one.

    Parameters
    ----------
    picture : GreyImage
    first : GreyImage
    warp : Warp
        First picture -> `picture`.
    """
    if first.mask.all():
        return picture
    return GreyImage(picture.grey, picture.mask & carried_mask(first.mask, warp, picture.shape))


def carried_mask(mask: Bools, warp: Warp, shape: tuple[int, int]) -> Bools:
    """Carry a mask through a warp by its outlines: what they enclose stays enclosed.

    Parameters
    ----------
    mask : (H, W) bool
    warp : Warp
        That folds nowhere on the mask.
    shape : (int, int)
        Height and width of the result.
    """
    import cv2

    found, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    drawn = np.zeros(shape, dtype=np.uint8)
    if len(found) == 0:
        return np.asarray(drawn, dtype=np.bool_)
    at = np.concatenate([outline[:, 0] for outline in found]).astype(np.float64)
    fine = np.rint(continue_warp(warp, at) * 2**FRACTION_BITS).astype(np.int32)
    outlines = np.split(fine, np.cumsum([len(outline) for outline in found])[:-1])
    cv2.fillPoly(drawn, outlines, 1, shift=FRACTION_BITS)
    return np.asarray(drawn, dtype=np.bool_)
