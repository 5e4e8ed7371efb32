"""Subset size and spacing from the picture itself."""

import logging
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys
from shapemorph.core.image import GreyImage
from shapemorph.methods.speckle import speckle_size

SPECKLES = 3.8  # across a subset
FEWEST_SPECKLES = 2.2  # across the smallest subset that a bent field asks for
FINEST_SIGMA = 0.03  # px, that such a subset may cost
LEAST_SIZE = 15  # px
LARGEST_SIZE = 61
LEAST_SPACING = 2
TARGET_SIGMA = 0.02  # px
POOR_PLACES = 10.0  # percentile of the local gradient content that has to suffice
BARE = 0.05  # of the usual gradient content: such places show no pattern, whatever the subset
TILE = 32  # px
USUAL_SPECKLE = 5.0  # px, where the picture shows none
log = logging.getLogger(__name__)
_PATTERNS: WeakKeyDictionary[GreyImage, tuple[float, float, float]] = WeakKeyDictionary()


@dataclass(frozen=True, slots=True)
class SubsetChoice:
    """Subset size and spacing, and why.

    Attributes
    ----------
    subset_size, spacing : int
        px.
    speckle_px : float
        Size of a speckle, px; NaN where none was found.
    grey_noise : float
        Estimated standard deviation of the noise of a pixel, grey in [0, 1].
    predicted_sigma_px : float
        Random standard deviation of a displacement component that is to be expected with
        this size where the pattern is poor, px.
    reason : str
        One sentence.
    """

    subset_size: int
    spacing: int
    speckle_px: float
    grey_noise: float
    predicted_sigma_px: float
    reason: str


def choose_subset(
    picture: GreyImage, *, subset_size: int | None, spacing: int | None
) -> SubsetChoice:
    """Choose what is not given: about four speckles, more where the noise asks for it.

    The random error of a displacement component is sqrt(2) sigma / sqrt(SSSIG), with the
    sum of squared grey gradients over the subset (Pan, Xie, Wang, Hua, Qian 2008,
    doi:10.1364/OE.16.007037).

    Parameters
    ----------
    picture : GreyImage
        The reference.
    subset_size, spacing : int or None
        px, as configured; None to choose.
    """
    speckle, noise, slopes = _pattern(picture)
    per_pixel = float(np.sqrt(2.0) * noise / np.sqrt(max(slopes, 1e-12)))
    by_speckle = SPECKLES * (speckle if np.isfinite(speckle) else USUAL_SPECKLE)
    by_noise = per_pixel / TARGET_SIGMA
    wanted = float(np.clip(max(by_speckle, by_noise), LEAST_SIZE, LARGEST_SIZE))
    size = subset_size if subset_size is not None else _nearest_odd(wanted)
    step = spacing if spacing is not None else max(LEAST_SPACING, round(size / 4))
    sigma = per_pixel / size
    reason = _reason(subset_size is None, size, speckle, by_noise > by_speckle, sigma)
    return SubsetChoice(size, step, speckle, noise, sigma, reason)


def settled_sizes(
    picture: GreyImage, *, subset_size: int | None, spacing: int | None
) -> tuple[int, int]:
    """Give subset size and spacing, px; the picture is measured only where one is to be chosen.

    Parameters
    ----------
    picture, subset_size, spacing
        As in :func:`choose_subset`.
    """
    if subset_size is not None and spacing is not None:
        return subset_size, spacing
    choice = choose_subset(picture, subset_size=subset_size, spacing=spacing)
    log.info("%s", choice.reason)
    return choice.subset_size, choice.spacing


def finest_subset(picture: GreyImage, *, order: int) -> int:
    """Smallest subset that still shows the pattern and keeps the noise small, px.

    Parameters
    ----------
    picture : GreyImage
        The reference.
    order : int
        Of the shape function; the second has twice the random error.
    """
    speckle, noise, slopes = _pattern(picture)
    per_pixel = float(np.sqrt(2.0) * noise / np.sqrt(max(slopes, 1e-12)))
    by_speckle = FEWEST_SPECKLES * (speckle if np.isfinite(speckle) else USUAL_SPECKLE)
    by_noise = per_pixel * (2.0 if order == 2 else 1.0) / FINEST_SIGMA
    return _nearest_odd(float(np.clip(max(by_speckle, by_noise), LEAST_SIZE, LARGEST_SIZE)))


def _pattern(picture: GreyImage) -> tuple[float, float, float]:
    """Size of a speckle, noise of grey and poor slopes, measured once of each picture."""
    known = _PATTERNS.get(picture)
    if known is None:
        speckle = speckle_size(picture.grey, picture.mask)
        known = speckle, grey_noise(picture), _poor_slopes(picture)
        _PATTERNS[picture] = known
    return known


def grey_noise(picture: GreyImage) -> float:
    """Estimate the standard deviation of the noise of a pixel.

    From the mixed second difference, to which a pattern that is finer than about four
    pixels contributes as well: rather too high than too low.

    References
    ----------
    J. Immerkaer, "Fast noise variance estimation", Computer Vision and Image
    Understanding 64 (1996), doi:10.1006/cviu.1996.0060.
    """
    grey, mask = picture.grey, picture.mask
    rows = grey[:-2] - 2.0 * grey[1:-1] + grey[2:]
    both = rows[:, :-2] - 2.0 * rows[:, 1:-1] + rows[:, 2:]
    if not mask.all():
        seen = mask[:-2] & mask[1:-1] & mask[2:]
        both = both[seen[:, :-2] & seen[:, 1:-1] & seen[:, 2:]]
    if both.size == 0:
        return 0.0
    return float(1.4826 * np.median(np.abs(both), overwrite_input=True) / 6.0)


def _poor_slopes(picture: GreyImage) -> float:
    """Mean squared slope per pixel along the worse axis, where the pattern is poor."""
    both = picture.mask[1:-1, 1:-1] & picture.mask[1:-1, 2:] & picture.mask[2:, 1:-1]
    both &= picture.mask[1:-1, :-2] & picture.mask[:-2, 1:-1]
    along_x = 0.5 * (picture.grey[1:-1, 2:] - picture.grey[1:-1, :-2])
    along_y = 0.5 * (picture.grey[2:, 1:-1] - picture.grey[:-2, 1:-1])
    count = _tile_sums(both)
    full = count >= 0.5 * TILE * TILE
    if not full.any():
        return 0.0
    means = [_tile_sums((s * both) ** 2)[full] / count[full] for s in (along_x, along_y)]
    worse = np.minimum(*means)
    shown = worse >= BARE * np.median(worse)
    return float(np.percentile(worse[shown], POOR_PLACES))


def _tile_sums(values: Greys | Bools) -> Floats:
    """Add up tiles; of a picture narrower than one, the part that is there."""
    height, width = (TILE * max(1, size // TILE) for size in values.shape)
    values = values[:height, :width]
    padded = np.pad(values, ((0, height - values.shape[0]), (0, width - values.shape[1])))
    rows = padded.reshape(height // TILE, TILE, width).sum(axis=1, dtype=np.float64)
    sums: Floats = rows.reshape(len(rows), width // TILE, TILE).sum(axis=2)
    return sums


def _nearest_odd(value: float) -> int:
    return 2 * round((value - 1.0) / 2.0) + 1


def _reason(automatic: bool, size: int, speckle: float, noisy: bool, sigma: float) -> str:  # noqa: FBT001
    expected = f"; about {sigma:.4f} px of random error is to be expected"
    if not automatic:
        return f"subset of {size} px as configured{expected}"
    if noisy:
        return f"subset of {size} px so that grey noise costs at most {TARGET_SIGMA} px{expected}"
    if not np.isfinite(speckle):
        return f"subset of {size} px, because no speckle size could be measured{expected}"
    return (
        f"subset of {size} px: {size / speckle:.1f} speckles of {speckle:.1f} px across{expected}"
    )
