"""How much brighter one picture is lit than another, from place to place."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys
from shapemorph.core.image import GreyImage

CELL = 8  # px; grey is averaged over cells
FULL = 0.5  # share of a cell that both pictures must show
ORDER = 3  # of the polynomial in x and y
POWERS = [(i, k - i) for k in range(ORDER + 1) for i in range(k + 1)]
LEAST_CELLS = 60  # several for each of its terms
ROUNDS, REJECTED = 4, 4.0  # fits, and standard deviations beyond which a cell is left out
UNEVEN = 0.02  # light that varies by less over the picture does no harm
CLEARLY = 12.0  # standard errors of the gain; neighbouring cells err alike
DARKEST = 0.2  # of the mean: dimmer light is not made up for


@dataclass(frozen=True, slots=True, eq=False)
class Light:
    """A smooth gain, 1 in the mean.

    Attributes
    ----------
    coefficients : (T,) float64
        Of the monomials of x and y over half the larger side, from the middle.
    shape : tuple of int
        Height and width of the pictures, px.
    """

    coefficients: Floats
    shape: tuple[int, int]

    def taken_off(self, image: GreyImage) -> GreyImage:
        """Divide a picture by this light, which goes on evenly beyond its own pictures."""
        table = np.zeros((ORDER + 1, ORDER + 1))
        for (i, j), coefficient in zip(POWERS, self.coefficients, strict=True):
            table[j, i] = coefficient
        y, x = (
            _scaled(np.clip(np.arange(n, dtype=np.float64), 0, of - 1), of, self.shape)
            for n, of in zip(image.shape, self.shape, strict=True)
        )
        down, across = (np.vander(at, ORDER + 1, increasing=True) for at in (y, x))
        gain = np.maximum(down @ table @ across.T, DARKEST)
        return GreyImage((image.grey / gain).astype(np.float32), image.mask)


def uneven_light(reference: GreyImage, deformed: GreyImage) -> Light | None:
    """Estimate what light, that varies smoothly, does to one picture and not to the other.

    The grey of the deformed picture, averaged over cells, is that of the reference times a
    polynomial gain, plus an offset; cells that keep to no such rule (glare, what was lost)
    are left out.

    Parameters
    ----------
    reference, deformed : GreyImage
        Of one size; each pixel shows about the same material in both.

    Returns
    -------
    Light or None
        None where the light is even within 2 %, or where too little is seen of both.
    """
    seen, before, after = _cell_means(reference, deformed)
    if len(before) < LEAST_CELLS:
        return None
    terms = _monomials(*seen)
    model = np.column_stack([terms * before[:, None], np.ones(len(before))])
    kept = np.ones(len(before), dtype=bool)
    for _ in range(ROUNDS):
        some = model[kept]
        found = np.linalg.lstsq(some.T @ some, some.T @ after[kept], rcond=1e-12)[0]
        left = after - model @ found
        far = np.abs(left)
        kept = far <= REJECTED * 1.4826 * max(float(np.median(far[kept])), 1e-6)
    gain = terms @ found[:-1]
    mean, varies = float(gain[kept].mean()), float(np.ptp(gain[kept]))
    noise = _noise_of_gain(model[kept], terms[kept], float(np.std(left[kept])))
    if not mean > 0 or varies < max(UNEVEN * mean, CLEARLY * noise):
        return None
    return Light(np.asarray(found[:-1] / mean, dtype=np.float64), reference.shape)


def _noise_of_gain(model: Floats, terms: Floats, scatter: float) -> float:
    """Median standard error of the gain at the cells, for independent errors of all cells."""
    inverse = np.linalg.pinv(model.T @ model)[:-1, :-1]
    variance = ((terms @ inverse) * terms).sum(axis=1)
    return scatter * float(np.sqrt(np.median(variance)))


def _cell_means(
    reference: GreyImage, deformed: GreyImage
) -> tuple[tuple[Floats, Floats], Floats, Floats]:
    """Find the middles of cells that both pictures show, and the mean grey of both there."""
    both = reference.mask & deformed.mask
    rows, columns = (size // CELL for size in both.shape)
    count = _summed(both, rows, columns)
    good: Bools = count >= FULL * CELL * CELL
    before, after = (
        _summed(np.where(both, side.grey, np.float32(0.0)), rows, columns)[good] / count[good]
        for side in (reference, deformed)
    )
    row, column = np.nonzero(good)
    middle = [
        _scaled(CELL * at.astype(np.float64) + (CELL - 1) / 2, size, both.shape)
        for at, size in ((column, both.shape[1]), (row, both.shape[0]))
    ]
    return (middle[0], middle[1]), before, after


def _summed(values: Greys | Bools, rows: int, columns: int) -> Floats:
    """Add up the pixels of each cell."""
    cells = values[: rows * CELL, : columns * CELL].reshape(rows, CELL, columns * CELL)
    return np.asarray(cells.sum(axis=1, dtype=np.float64).reshape(rows, columns, CELL).sum(axis=2))


def _scaled(at: Floats, size: int, shape: tuple[int, ...]) -> Floats:
    """Turn px along a side of some size into halves of the larger side, from its middle."""
    return np.asarray((at - (size - 1) / 2) / (max(shape) / 2))


def _monomials(x: Floats, y: Floats) -> Floats:
    """x^i y^j with i + j up to the order, in the last axis; the first is 1."""
    return np.stack([x**i * y**j for i, j in POWERS], axis=-1)
