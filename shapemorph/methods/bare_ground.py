"""What of a picture shows nothing but noise: the ground beside a specimen."""

import numpy as np
from scipy.ndimage import binary_closing

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.image import GreyImage

TILE = 32  # px
STRONG = 95.0  # percentile of the tiles whose pattern the others are held against
FAINT = 0.05  # of the squared slopes of strong tiles: fainter ones may be bare
WHITE = 4.0  # times the squared slopes of white noise: more is pattern, however faint
DARK = 1e-9  # squared slope of grey that does not change at all
LEAST_LEFT = 0.02  # of the picture: less is no specimen


def without_ground(picture: GreyImage) -> GreyImage:
    """Limit a picture to where it shows a pattern.

    A tile is bare where its slopes are faint beside those of the strongest tiles, and no
    stronger than its own noise makes them; between tiles with a pattern it stays. A picture
    without bare tiles, or with hardly any others, stays as it is.

    Parameters
    ----------
    picture : GreyImage
    """
    slopes, noise, seen = _contents(picture)
    if not seen.any():
        return picture
    strong = float(np.percentile(slopes[seen], STRONG))
    bare = seen & (slopes < FAINT * strong) & (slopes < WHITE * noise + DARK)
    pattern = seen & ~bare
    shown = pattern | binary_closing(pattern, np.ones((3, 3), dtype=np.bool_))
    if not bare.any() or shown.mean() < LEAST_LEFT:
        return picture
    height, width = picture.shape
    pixels = shown.repeat(TILE, axis=0).repeat(TILE, axis=1)[:height, :width]
    return GreyImage(picture.grey, picture.mask & pixels)


def _contents(picture: GreyImage) -> tuple[Floats, Floats, Bools]:
    """Mean squared slope and variance of the noise of every tile, and which tiles are seen.

    The noise is told from the mixed second difference, which a pattern hardly changes.
    """
    grey, mask = picture.grey, picture.mask
    whole: Bools = np.zeros_like(mask)
    whole[1:-1, 1:-1] = mask[1:-1, 1:-1]
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            whole[1:-1, 1:-1] &= np.roll(mask, (down, right), axis=(0, 1))[1:-1, 1:-1]
    slopes, rough = np.zeros((2, *mask.shape), dtype=np.float32)
    across = 0.5 * (grey[1:-1, 2:] - grey[1:-1, :-2])
    along = 0.5 * (grey[2:, 1:-1] - grey[:-2, 1:-1])
    slopes[1:-1, 1:-1] = across**2 + along**2
    rows = grey[:-2] - 2.0 * grey[1:-1] + grey[2:]
    rough[1:-1, 1:-1] = ((rows[:, :-2] - 2.0 * rows[:, 1:-1] + rows[:, 2:]) / 6.0) ** 2
    count = _tile_sums(whole.astype(np.float32))
    number = np.maximum(count, 1.0)
    return (
        _tile_sums(slopes * whole) / number,
        _tile_sums(rough * whole) / number,
        np.asarray(count > 0),
    )


def _tile_sums(values: Floats) -> Floats:
    height, width = (-(-size // TILE) for size in values.shape)
    padded = np.zeros((height * TILE, width * TILE))
    padded[: values.shape[0], : values.shape[1]] = values
    sums: Floats = padded.reshape(height, TILE, width, TILE).sum(axis=(1, 3))
    return sums
