"""The measured part of a picture, carried into a later one."""

from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.methods.morphing import morph_image
from shapemorph.methods.warp_inverse import inverse_warp


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
    back = inverse_warp(warp, first.mask, picture.shape)
    return GreyImage(picture.grey, picture.mask & morph_image(first, back, picture.shape).mask)
