"""Even out light and contrast, so that only the pattern remains."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from shapemorph.core.arrays import Bools, Floats, Greys
from shapemorph.core.image import GreyImage
from shapemorph.methods.mask_box import tight_map

Bytes: TypeAlias = NDArray[np.uint8]

FAINT = 0.1  # of the usual local contrast: weaker pattern is not amplified to full strength


@dataclass(frozen=True, slots=True, eq=False)
class Pattern:
    """A picture of zero local mean and about unit local contrast.

    Attributes
    ----------
    values : (H, W) float32
        Zero outside the mask.
    mask : (H, W) bool
    contrast : float
        Median local standard deviation that the picture had, grey levels in [0, 1].
    """

    values: Greys
    mask: Bools
    contrast: float

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width, px."""
        height, width = self.values.shape
        return height, width


def even_contrast(image: GreyImage, *, window: int, rounding: Floats | None = None) -> Pattern:
    """Subtract the local mean and divide by the local standard deviation.

    Means are taken over the part of each window that lies inside the mask (normalised
    convolution), so that the rim of the specimen leaves no trace of what is outside.

    Parameters
    ----------
    image : GreyImage
    window : int
        Width of the square window, px: some ten speckles.
    rounding : (2, 2), optional
        Linear map of the picture after which the window is square; it makes the speckle
        round, so that the window is stretched like the material.
    """
    over = _Windows(window, image.mask, rounding)
    inside = image.mask.astype(np.float32)
    offset = float(image.grey[image.mask].mean()) if image.mask.any() else 0.0
    grey = np.where(image.mask, image.grey - np.float32(offset), np.float32(0.0))
    share = np.maximum(over.mean(inside), np.float32(1e-6))
    mean = over.mean(grey) / share
    variance = np.maximum(over.mean(grey * grey) / share - mean * mean, 0.0)
    contrast = float(np.sqrt(np.median(variance[image.mask]))) if image.mask.any() else 0.0
    floor = max((FAINT * contrast) ** 2, 1e-12)
    values = np.where(image.mask, (grey - mean) / np.sqrt(variance + floor), 0.0)
    return Pattern(values.astype(np.float32), image.mask, contrast)


def byte_picture(values: Greys) -> Bytes:
    """Show a pattern as 8-bit grey: zero is 128, one standard deviation 40 levels."""
    levels: Bytes = np.clip(np.rint(values * 40.0 + 128.0), 0, 255).astype(np.uint8)
    return levels


@dataclass(frozen=True, slots=True, eq=False)
class _Windows:
    """Square windows, or what a linear map makes square."""

    width: int
    mask: Bools
    rounding: Floats | None

    def mean(self, values: Greys) -> Greys:
        """Mean of a picture (H, W) over the window about every pixel."""
        import cv2

        if self.rounding is None or not self.mask.any():
            return _box(values, self.width)
        matrix, (height, width) = tight_map(self.rounding, self.mask)
        smallest = float(np.linalg.svd(self.rounding, compute_uv=False)[1])
        soft = cv2.GaussianBlur(values, (0, 0), 0.35 / min(smallest, 1.0))
        mapped = cv2.warpAffine(soft, matrix, (width, height))
        back = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        mean: Greys = cv2.warpAffine(
            _box(np.asarray(mapped, np.float32), self.width), matrix, values.shape[::-1], flags=back
        )
        return mean


def _box(values: Greys, window: int) -> Greys:
    import cv2

    blurred: Greys = cv2.blur(values, (window, window), borderType=cv2.BORDER_CONSTANT)
    return blurred
