"""Two pictures of one pattern, made alike in light and sharpness before they are correlated."""

import logging
from collections.abc import Callable

import numpy as np

from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.core.morphed import Morphed
from shapemorph.methods.light import CELL, uneven_light
from shapemorph.methods.near_start import NearStart
from shapemorph.methods.sharpness import blurred, missing_blur
from shapemorph.methods.warping import warp_points

WIDEST = 32767  # px: OpenCV numbers the pixels of what it resamples by 16 bits
NOWHERE = -1e6  # px: a motion that ends beyond all pictures

log = logging.getLogger(__name__)


def made_alike(
    reference: GreyImage,
    remorph: Callable[[Warp], GreyImage],
    morphed: Morphed,
    start: NearStart | None,
) -> tuple[GreyImage, Callable[[Warp], GreyImage], Morphed]:
    """Make both sides alike in light, and in sharpness where the pictures lie over each other.

    Parameters
    ----------
    reference : GreyImage
    remorph : callable
        Morphs the deformed picture through another warp.
    morphed : Morphed
    start : NearStart or None
        Of two originals that are compared as they are, `morphed` being the deformed one.

    Returns
    -------
    reference, remorph, morphed
        With everything that differs taken off; `morphed` itself where nothing does.
    """
    remorph, morphed = _as_lit(reference, remorph, morphed, start)
    if start is not None:
        return reference, remorph, morphed
    return _as_soft(reference, remorph, morphed)


def _as_lit(
    reference: GreyImage,
    remorph: Callable[[Warp], GreyImage],
    morphed: Morphed,
    start: NearStart | None,
) -> tuple[Callable[[Warp], GreyImage], Morphed]:
    """Take off the deformed picture what light does to it and not to the reference.

    With a near start the two originals are compared, laid over each other as it says.
    """
    seen = morphed.image
    if start is not None:
        small = max(*reference.shape, *seen.shape) < WIDEST
        seen = laid_over(seen, start.warp, reference.shape) if small else remorph(start.warp)
    light = uneven_light(reference, seen)
    if light is None:
        return remorph, morphed
    log.info("the light on the deformed side varies otherwise than on the reference: evened out")
    return (
        lambda warp: light.taken_off(remorph(warp)),
        Morphed(light.taken_off(morphed.image), morphed.warp),
    )


def laid_over(image: GreyImage, warp: Warp, shape: tuple[int, int]) -> GreyImage:
    """Read a picture in the frame of another, well enough to compare the means of cells.

    The motion is linear between the middles of the cells, and so is the grey between pixels.

    Parameters
    ----------
    image : GreyImage
    warp : Warp
        Px of the other picture -> px of this one.
    shape : (int, int)
        Height and width of the other picture.

    Returns
    -------
    GreyImage
        The mask holds the pixels that come to lie between pixels of this one's mask.
    """
    import cv2

    rows, cols = (-(-size // CELL) for size in shape)
    middle = (CELL - 1) / 2
    x, y = np.meshgrid(CELL * np.arange(cols) + middle, CELL * np.arange(rows) + middle)
    at = np.stack([x, y], axis=-1)
    motion = (warp_points(warp, at.reshape(-1, 2))[0].reshape(at.shape) - at).astype(np.float32)
    motion[~np.isfinite(motion).all(axis=-1)] = NOWHERE
    motion = np.pad(motion, ((1, 1), (1, 1), (0, 0)), mode="reflect", reflect_type="odd")
    size = CELL * (cols + 2), CELL * (rows + 2)
    motion = cv2.resize(motion, size, interpolation=cv2.INTER_LINEAR)
    to = motion[CELL : CELL + shape[0], CELL : CELL + shape[1]]
    to += np.stack(np.meshgrid(*(np.arange(n, dtype=np.float32) for n in shape[::-1])), axis=-1)
    whole = np.where(image.mask, np.uint8(255), np.uint8(0))
    mask = cv2.remap(whole, to, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    grey = cv2.remap(image.grey, to, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return GreyImage(grey, mask == 255)


def _as_soft(
    reference: GreyImage, remorph: Callable[[Warp], GreyImage], morphed: Morphed
) -> tuple[GreyImage, Callable[[Warp], GreyImage], Morphed]:
    """Blur what is sharper than the other side, so that both show the same."""
    missing = missing_blur(reference, morphed.image)
    if not missing:
        return reference, remorph, morphed
    for name, covariance in (("reference", missing.reference), ("deformed", missing.deformed)):
        widths = np.sqrt(np.linalg.eigvalsh(covariance).clip(0.0))
        log.info("the %s is softened by %.1f and %.1f px to match", name, *widths)
    soft = Morphed(blurred(morphed.image, missing.deformed), morphed.warp)
    return (
        blurred(reference, missing.reference),
        lambda warp: blurred(remorph(warp), missing.deformed),
        soft,
    )
