"""How well a picture can be correlated: gradients, contrast, saturation."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.image import GreyImage

LEVELS = 255.0
"""Grey levels are those of 8 bit whatever the file has."""
CLIPPED = 0.5  # grey levels from the end of the range


@dataclass(frozen=True, slots=True)
class PictureQuality:
    """Figures of a picture inside its mask; grey in levels of 255.

    Attributes
    ----------
    mean_grey, contrast : float
        Mean and standard deviation of grey.
    clipped_share : float
        Share of pixels at either end of the range.
    mean_gradient : float
        Mean intensity gradient, the mean of ``|grad grey|``, levels / px.
    sssig_x, sssig_y : float
        Sum of squared grey gradients over a subset, along x and along y, levels^2: median
        over the subsets that lie inside the mask; NaN where there is none.
    sssig_poor : float
        The smaller of both where the pattern is poor: exceeded by nine tenths of the subsets.
    """

    mean_grey: float
    contrast: float
    clipped_share: float
    mean_gradient: float
    sssig_x: float
    sssig_y: float
    sssig_poor: float


def picture_quality(picture: GreyImage, *, subset_size: int, noise: float) -> PictureQuality:
    """Measure a picture.

    Parameters
    ----------
    picture : GreyImage
    subset_size : int
        For which the sums of squared gradients are taken, px.
    noise : float
        Standard deviation of the grey noise of a pixel, levels: its share of the squared
        differences is taken off the sums.

    References
    ----------
    B. Pan, Z. Lu, H. Xie, "Mean intensity gradient", Opt. Lasers Eng. 48 (2010),
    doi:10.1016/j.optlaseng.2009.08.010. SSSIG: B. Pan, H. Xie, Z. Wang, K. Qian, Z. Wang,
    Opt. Express 16 (2008), doi:10.1364/OE.16.007037.
    """
    grey = LEVELS * picture.grey.astype(np.float64)
    shown = grey[picture.mask]
    along_x, along_y, known = _slopes(grey, picture.mask)
    size = np.hypot(along_x, along_y)[known]
    sums = [_subset_sums(slope, known, subset_size, noise) for slope in (along_x, along_y)]
    found = len(sums[0]) > 0
    return PictureQuality(
        mean_grey=float(shown.mean()),
        contrast=float(shown.std()),
        clipped_share=float(((shown < CLIPPED) | (shown > LEVELS - CLIPPED)).mean()),
        mean_gradient=float(size.mean()) if size.size else float("nan"),
        sssig_x=float(np.median(sums[0])) if found else float("nan"),
        sssig_y=float(np.median(sums[1])) if found else float("nan"),
        sssig_poor=float(np.percentile(np.minimum(*sums), 10.0)) if found else float("nan"),
    )


def predicted_sigma(noise: float, sssig: float) -> float:
    """Random standard deviation of a displacement component, px: sqrt(2) sigma / sqrt(SSSIG)."""
    return float(np.sqrt(2.0) * noise / np.sqrt(sssig)) if sssig > 0 else float("nan")


def _slopes(grey: Floats, mask: Bools) -> tuple[Floats, Floats, Bools]:
    """Central differences along x and y, and where all four neighbours lie on the mask."""
    along_x, along_y = np.zeros_like(grey), np.zeros_like(grey)
    along_x[:, 1:-1] = 0.5 * (grey[:, 2:] - grey[:, :-2])
    along_y[1:-1] = 0.5 * (grey[2:] - grey[:-2])
    known = np.zeros_like(mask)
    known[1:-1, 1:-1] = (
        mask[1:-1, 1:-1] & mask[1:-1, 2:] & mask[1:-1, :-2] & mask[2:, 1:-1] & mask[:-2, 1:-1]
    )
    return along_x, along_y, known


def _subset_sums(slope: Floats, known: Bools, size: int, noise: float) -> Floats:
    """Add up over subsets that lie inside, a fourth of a subset apart, without the noise."""
    squares = np.where(known, slope**2 - noise**2 / 2.0, 0.0)
    total, count = (_box_sums(each, size) for each in (squares, known.astype(np.float64)))
    step = max(1, size // 4)
    whole = count[::step, ::step] > size * size - 0.5
    return np.maximum(total[::step, ::step][whole], 0.0)


def _box_sums(values: Floats, size: int) -> Floats:
    """Add up over all boxes of size x size px, (H - size + 1, W - size + 1)."""
    height, width = values.shape
    if min(height, width) < size:
        return np.zeros((0, 0))
    whole = np.zeros((height + 1, width + 1))
    whole[1:, 1:] = values.cumsum(axis=0).cumsum(axis=1)
    sums: Floats = (
        whole[size:, size:] - whole[:-size, size:] - whole[size:, :-size] + whole[:-size, :-size]
    )
    return sums
