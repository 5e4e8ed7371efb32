"""Glare: where a picture is so bright that it shows light and not the surface."""

import numpy as np

from shapemorph.core.image import GreyImage

_WHITE = 0.97  # grey of pixels that say nothing
_HALO = 0.012  # of the width of the picture: what lies so near to them is brightened, too
_LEAST_SPOT = 3  # px: smaller ones are noise on a bright ground


def without_glare(picture: GreyImage) -> GreyImage:
    """Take saturated spots and what surrounds them out of the mask of a picture.

    Glare stays with the lights and not with the surface: points that are matched there lie off.
    """
    import cv2

    white = (picture.grey >= _WHITE) & picture.mask
    spots = cv2.morphologyEx(
        white.astype(np.uint8), cv2.MORPH_OPEN, np.ones((_LEAST_SPOT, _LEAST_SPOT), np.uint8)
    )
    if not spots.any():
        return picture
    reach = max(1, round(_HALO * picture.shape[1]))
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    return GreyImage(picture.grey, picture.mask & (cv2.dilate(spots, around) == 0))
