"""Pictures made ready for matching subsets: spline coefficients, slopes, pixels that count."""

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from shapemorph.core.arrays import Bools, Greys
from shapemorph.core.image import GreyImage
from shapemorph.kernels.vectors import LANES
from shapemorph.methods.spline_coefficients import CUBIC, QUINTIC, to_coefficients

Pixels = TypeVar("Pixels", Greys, NDArray[np.uint8])

SMOOTH: dict[int, Greys] = {  # a B-spline at its knots, by its degree
    CUBIC: np.array([1, 4, 1], dtype=np.float32) / np.float32(6),
    QUINTIC: np.array([1, 26, 66, 26, 1], dtype=np.float32) / np.float32(120),
}
SLOPE: dict[int, Greys] = {  # its derivative there
    CUBIC: np.array([-0.5, 0.0, 0.5], dtype=np.float32),
    QUINTIC: np.array([-1, -10, 0, 10, 1], dtype=np.float32) / np.float32(24),
}
RINGS = 4  # the prefilter of a cubic spline forgets by 0.27 per pixel: 0.5 % after four


@dataclass(frozen=True, slots=True, eq=False)
class ReferencePicture:
    """The reference side: grey, slopes and the pixels that count, padded on all sides.

    Attributes
    ----------
    planes : (3, H, W) float32
        Grey, its derivative along x, along y, of the spline through the pixels.
    inside : (H, W) float32
        1 where a pixel counts.
    counts : (H + 1, W + 1) int32
        Number of counting pixels above and left of each corner.
    pad : int
        px added on the left and on top.
    degree : int
        Of the spline: 3 or 5.
    """

    planes: Greys
    inside: Greys
    counts: np.ndarray[tuple[int, int], np.dtype[np.int32]]
    pad: int
    degree: int


@dataclass(frozen=True, slots=True, eq=False)
class DeformedPicture:
    """The deformed side: spline coefficients and the pixels that count, padded alike.

    Attributes
    ----------
    coefficients : (H, W) float32
    inside : (H, W) float32
    counts : (H + 1, W + 1) int32
        Number of counting pixels above and left of each corner.
    degree : int
        Of the spline: 3 or 5.
    """

    coefficients: Greys
    inside: Greys
    counts: np.ndarray[tuple[int, int], np.dtype[np.int32]]
    degree: int

    @property
    def wide(self) -> int | None:
        """None for a cubic spline, as the kernels want it."""
        return None if self.degree == CUBIC else self.degree


def prepare_reference(
    picture: GreyImage, *, allowed: Bools | None, pad: int, degree: int = CUBIC
) -> ReferencePicture:
    """Find the slopes of the reference and the pixels that count.

    Pixels on the rim of the mask do not count: their slope needs neighbours.

    Parameters
    ----------
    picture : GreyImage
    allowed : (H, W) bool or None
        Pixels that may count; None for all of the mask.
    pad : int
        px to add around.
    degree : int
        Of the spline through the pixels: 3 or 5.
    """
    grey = extend_grey(picture)
    coefficients = _spline(grey, degree)
    planes = _padding(3, grey.shape, pad)
    inner = (slice(pad, pad + grey.shape[0]), slice(pad, pad + grey.shape[1]))
    planes[0][inner] = grey
    planes[1][inner] = _filtered(coefficients, SLOPE[degree], SMOOTH[degree])
    planes[2][inner] = _filtered(coefficients, SMOOTH[degree], SLOPE[degree])
    inside = shrink(picture.mask)
    if allowed is not None:
        inside &= allowed
    return ReferencePicture(planes, *_counted(inside, pad), pad, degree)


def prepare_deformed(picture: GreyImage, *, pad: int, degree: int = CUBIC) -> DeformedPicture:
    """Find the spline through the deformed picture and the pixels that count."""
    coefficients = _pad(_spline(extend_grey(picture), degree), pad)
    _mirror_rim(coefficients, pad)
    return DeformedPicture(coefficients, *_counted(shrink(picture.mask), pad), degree)


def _counted(inside: Bools, pad: int) -> tuple[Greys, np.ndarray[Any, np.dtype[np.int32]]]:
    """Pixels that count, padded, and the number of them above and left of each corner."""
    import cv2

    padded = _pad(inside.view(np.uint8), pad)
    return padded.astype(np.float32), cv2.integral(padded, sdepth=cv2.CV_32S)


def shrink(mask: Bools) -> Bools:
    """Mask without its outermost pixels, those on the border of the picture included."""
    inner = np.zeros_like(mask)
    rows = mask[:-2] & mask[1:-1] & mask[2:]
    inner[1:-1, 1:-1] = rows[:, :-2] & rows[:, 1:-1] & rows[:, 2:]
    return inner


def extend_grey(picture: GreyImage) -> Greys:
    """Grey continued a few pixels beyond the mask, so that a spline does not ring there.

    Each ring takes the mean of the known neighbours; farther out the grey is the mean of
    the specimen.
    """
    import cv2

    if picture.mask.all() or not picture.mask.any():
        return picture.grey
    known = picture.mask.astype(np.float32)
    grey = np.where(picture.mask, picture.grey, np.float32(0.0))
    for _ in range(RINGS):
        share, total = (
            cv2.blur(each, (3, 3), borderType=cv2.BORDER_CONSTANT) for each in (known, grey)
        )
        fresh = (known == 0) & (share > 0.05)
        grey[fresh] = total[fresh] / share[fresh]
        known[fresh] = 1.0
    grey[known == 0] = picture.grey[picture.mask].mean()
    return grey


def _spline(grey: Greys, degree: int) -> Greys:
    """Coefficients of the interpolating spline, mirrored at the border."""
    coefficients = np.array(grey, dtype=np.float32, order="C")
    to_coefficients(coefficients, 0, degree=degree)
    return coefficients


def _filtered(coefficients: Greys, along_x: Greys, along_y: Greys) -> Greys:
    """Value or slope of a spline at its knots, by weights along both axes."""
    import cv2

    found: Greys = cv2.sepFilter2D(
        coefficients, cv2.CV_32F, along_x, along_y, borderType=cv2.BORDER_REFLECT_101
    )
    return found


def _padding(planes: int, shape: tuple[int, ...], pad: int) -> Greys:
    return np.zeros((planes, shape[0] + 2 * pad, shape[1] + 2 * pad + LANES), dtype=np.float32)


def _pad(values: Pixels, pad: int) -> Pixels:
    return np.pad(values, ((pad, pad), (pad, pad + LANES)))


def _mirror_rim(coefficients: Greys, pad: int) -> None:
    """Give the padding the two rows and columns that the spline at the border needs."""
    height, width = coefficients.shape[0] - 2 * pad, coefficients.shape[1] - 2 * pad - LANES
    for k in (1, 2):
        coefficients[pad - k] = coefficients[pad + k]
        coefficients[pad + height - 1 + k] = coefficients[pad + height - 1 - k]
    for k in (1, 2):
        coefficients[:, pad - k] = coefficients[:, pad + k]
        coefficients[:, pad + width - 1 + k] = coefficients[:, pad + width - 1 - k]


def detail_length(reference: ReferencePicture) -> float:
    """Contrast over slope of the pattern, px: how far a motion changes the grey by its spread.

    The random error of a match is about this length times sqrt((1 - ZNCC^2) / pixels).
    """
    import cv2

    inside = (reference.inside > 0).view(np.uint8)
    (_, spread), *slopes = (cv2.meanStdDev(plane, mask=inside) for plane in reference.planes)
    slope = 0.5 * sum(float(mean[0, 0] ** 2 + std[0, 0] ** 2) for mean, std in slopes)
    return float(spread[0, 0] / np.sqrt(max(slope, 1e-12)))
