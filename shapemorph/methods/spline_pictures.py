"""Pictures made ready for matching subsets: spline coefficients, slopes, pixels that count."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Greys
from shapemorph.core.image import GreyImage
from shapemorph.kernels.vectors import LANES

RINGS = 4  # the spline prefilter forgets by 0.27 per pixel: 0.5 % after four


@dataclass(frozen=True, slots=True, eq=False)
class ReferencePicture:
    """The reference side: grey, slopes and the pixels that count, padded on all sides.

    Attributes
    ----------
    planes : (3, H, W) float32
        Grey, its derivative along x, along y, of the cubic spline through the pixels.
    inside : (H, W) float32
        1 where a pixel counts.
    counts : (H + 1, W + 1) int32
        Number of counting pixels above and left of each corner.
    pad : int
        px added on the left and on top.
    """

    planes: Greys
    inside: Greys
    counts: np.ndarray[tuple[int, int], np.dtype[np.int32]]
    pad: int


@dataclass(frozen=True, slots=True, eq=False)
class DeformedPicture:
    """The deformed side: spline coefficients and the pixels that count, padded alike.

    Attributes
    ----------
    coefficients : (H, W) float32
    inside : (H, W) float32
    counts : (H + 1, W + 1) int32
        Number of counting pixels above and left of each corner.
    """

    coefficients: Greys
    inside: Greys
    counts: np.ndarray[tuple[int, int], np.dtype[np.int32]]


def prepare_reference(picture: GreyImage, *, allowed: Bools | None, pad: int) -> ReferencePicture:
    """Find the slopes of the reference and the pixels that count.

    Pixels on the rim of the mask do not count: their slope needs neighbours.

    Parameters
    ----------
    picture : GreyImage
    allowed : (H, W) bool or None
        Pixels that may count; None for all of the mask.
    pad : int
        px to add around.
    """
    coefficients = _spline(extend_grey(picture))
    smooth_x, smooth_y = _smooth(coefficients, 1), _smooth(coefficients, 0)
    grey = _smooth(smooth_x, 0)
    slope_x, slope_y = _differ(smooth_y, 1), _differ(smooth_x, 0)
    planes = np.stack([_pad(each, pad) for each in (grey, slope_x, slope_y)])
    inside = shrink(picture.mask)
    if allowed is not None:
        inside &= allowed
    weights = _pad(inside.astype(np.float32), pad)
    return ReferencePicture(planes, weights, _count(weights), pad)


def prepare_deformed(picture: GreyImage, *, pad: int) -> DeformedPicture:
    """Find the spline through the deformed picture and the pixels that count."""
    coefficients = _pad(_spline(extend_grey(picture)), pad)
    _mirror_rim(coefficients, pad)
    inside = _pad(shrink(picture.mask).astype(np.float32), pad)
    return DeformedPicture(coefficients, inside, _count(inside))


def _count(inside: Greys) -> np.ndarray[tuple[int, int], np.dtype[np.int32]]:
    counts = np.zeros((inside.shape[0] + 1, inside.shape[1] + 1), dtype=np.int32)
    np.cumsum(inside > 0, axis=0, dtype=np.int32, out=counts[1:, 1:])
    np.cumsum(counts[1:, 1:], axis=1, out=counts[1:, 1:])
    return counts


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
    from scipy.ndimage import uniform_filter

    known = picture.mask.astype(np.float32)
    if picture.mask.all() or not picture.mask.any():
        return picture.grey
    grey = np.where(picture.mask, picture.grey, np.float32(0.0))
    for _ in range(RINGS):
        share = uniform_filter(known, 3, mode="constant")
        fresh = (known == 0) & (share > 0.05)
        grey[fresh] = uniform_filter(grey, 3, mode="constant")[fresh] / share[fresh]
        known[fresh] = 1.0
    grey[known == 0] = picture.grey[picture.mask].mean()
    return grey


def _spline(grey: Greys) -> Greys:
    from scipy.ndimage import spline_filter

    coefficients: Greys = spline_filter(grey, order=3, output=np.float32, mode="mirror")
    return coefficients


def _smooth(values: Greys, axis: int) -> Greys:
    """Value of a cubic spline at its knots along one axis, mirrored at the ends."""
    before, after = _neighbours(values, axis)
    smoothed: Greys = values * np.float32(2 / 3) + (before + after) * np.float32(1 / 6)
    return smoothed


def _differ(values: Greys, axis: int) -> Greys:
    """Differentiate a cubic spline at its knots along one axis, mirrored at the ends."""
    before, after = _neighbours(values, axis)
    slope: Greys = (after - before) * np.float32(0.5)
    return slope


def _neighbours(values: Greys, axis: int) -> tuple[Greys, Greys]:
    width = [(0, 0), (0, 0)]
    width[axis] = (1, 1)
    wide = np.pad(values, width, mode="reflect")
    return (wide[:-2], wide[2:]) if axis == 0 else (wide[:, :-2], wide[:, 2:])


def _pad(values: Greys, pad: int) -> Greys:
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
    inside = reference.inside > 0
    grey, along_x, along_y = (plane[inside].astype(np.float64) for plane in reference.planes)
    slope = 0.5 * ((along_x**2).mean() + (along_y**2).mean())
    return float(np.sqrt(grey.var() / max(slope, 1e-12)))
