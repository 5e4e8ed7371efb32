"""Two pictures of one pattern, seen as sharply as each other."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys, Ints
from shapemorph.core.image import GreyImage
from shapemorph.methods.speckle_ellipse import mean_covariance
from shapemorph.methods.views import blur_anisotropic

TILE, MOST_TILES = 96, 24  # px; looked at
FULL = 0.9  # share of a tile that both pictures must show
INSIDE = np.pad(np.ones((TILE - 8, TILE - 8), dtype=bool), 4)  # of a tile: slopes need neighbours
LEAST_TILES = 3
LEAST_BLUR = 0.12  # px^2, and ...
LEAST_SHARE = 0.03  # ... of the speckle's own covariance: less does no harm
LEAST_OF_LARGER = 0.1  # of the blur along the other direction, which changes the contrast of both


@dataclass(frozen=True, slots=True, eq=False)
class MissingBlur:
    """What two pictures must be blurred by so that both are as soft as the softer one.

    Attributes
    ----------
    reference, deformed : (2, 2) float64
        Covariances in the order x, y, px^2; one may be softer along one direction, the
        other along another.
    """

    reference: Floats
    deformed: Floats

    def __bool__(self) -> bool:
        """Whether there is anything to blur."""
        return bool(self.reference.any() or self.deformed.any())


SAME = MissingBlur(np.zeros((2, 2)), np.zeros((2, 2)))


def missing_blur(reference: GreyImage, deformed: GreyImage) -> MissingBlur:
    """Estimate how much softer one picture is than the other, and along what.

    A blur adds its covariance to that of the speckle. So the difference of the two
    speckles, median over some tiles, is the blur that one picture has and the other
    lacks: of a lens out of focus, or of a side that is stretched and seen with few
    pixels.

    Parameters
    ----------
    reference, deformed : GreyImage
        Of one size; each pixel shows about the same material in both.
    """
    both = reference.mask & deformed.mask
    found = [
        [mean_covariance(_even(side.grey, at), INSIDE) for side in (reference, deformed)]
        for at in _tiles(both)
    ]
    pairs = [pair for pair in found if all(side is not None for side in pair)]
    if len(pairs) < LEAST_TILES:
        return SAME
    ours, theirs = np.median(np.array(pairs, np.float64), axis=0)
    eigenvalues, axes = np.linalg.eigh(theirs - ours)
    sharper = 0.5 * float(min(np.trace(ours), np.trace(theirs)))
    larger = float(np.abs(eigenvalues).max())
    least = max(LEAST_BLUR, LEAST_SHARE * sharper, LEAST_OF_LARGER * larger)
    counted = np.where(np.abs(eigenvalues) >= least, eigenvalues, 0.0)
    return MissingBlur(
        (axes * np.maximum(counted, 0.0)) @ axes.T, (axes * np.maximum(-counted, 0.0)) @ axes.T
    )


def blurred(image: GreyImage, covariance: Floats) -> GreyImage:
    """Blur a picture by a Gaussian, of what lies inside its mask only."""
    if not covariance.any():
        return image
    inside = image.mask.astype(np.float32)
    share = blur_anisotropic(inside, covariance)
    grey = blur_anisotropic(image.grey * inside, covariance)
    soft = np.where(image.mask, grey / np.maximum(share, np.float32(1e-3)), image.grey)
    return GreyImage(soft.astype(np.float32), image.mask)


def _tiles(mask: Bools) -> Ints:
    """(N, 2) corners of some tiles that lie inside the mask; neighbours share half of them."""
    step = TILE // 2
    rows, cols = (size // step for size in mask.shape)
    share = mask[: rows * step, : cols * step].reshape(rows, step, cols, step).mean(axis=(1, 3))
    share = 0.5 * (share[1:] + share[:-1])
    share = 0.5 * (share[:, 1:] + share[:, :-1])
    full = np.argwhere(share >= FULL)
    chosen = np.unique(np.linspace(0, len(full) - 1, min(len(full), MOST_TILES)).astype(int))
    return np.asarray(full[chosen] * step if len(full) else full, np.int64)


def _even(grey: Greys, corner: Ints) -> Greys:
    """Tile less the plane through its light, with unit contrast."""
    tile = grey[corner[0] : corner[0] + TILE, corner[1] : corner[1] + TILE].astype(np.float64)
    step = np.linspace(-1.0, 1.0, TILE)
    weight = step / (TILE * float((step**2).sum()))
    tile = tile - tile.mean()
    tile -= (tile @ np.ones(TILE) @ weight) * step[:, None]
    tile -= (np.ones(TILE) @ tile @ weight) * step
    even: Greys = (tile / max(float(tile.std()), 1e-6)).astype(np.float32)
    return even
