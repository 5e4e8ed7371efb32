"""Two pictures of one pattern, made alike in light and sharpness before they are correlated."""

import logging
from collections.abc import Callable

import numpy as np

from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.core.morphed import Morphed
from shapemorph.kernels.zncc import resample_through
from shapemorph.methods.light import uneven_light
from shapemorph.methods.near_start import NearStart
from shapemorph.methods.sharpness import blurred, missing_blur

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

    With a near start the two originals are compared, laid over each other as it says. The light
    is smooth, and what differs averages out over its cells, so linear interpolation is enough.
    """
    seen = morphed.image
    if start is not None:
        seen = _laid_over(seen, start.warp, reference.shape)
    light = uneven_light(reference, seen)
    if light is None:
        return remorph, morphed
    log.info("the light on the deformed side varies otherwise than on the reference: evened out")
    return (
        lambda warp: light.taken_off(remorph(warp)),
        Morphed(light.taken_off(morphed.image), morphed.warp),
    )


def _laid_over(image: GreyImage, warp: Warp, shape: tuple[int, int]) -> GreyImage:
    """Show a picture in the frame of another of a given shape, through a warp, bilinearly."""
    frame = warp.coefficients, warp.origin, warp.spacing
    grey, visible = resample_through(*frame, image.grey, image.mask, *shape, 1.0)
    return GreyImage(grey, visible > 0)


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
