"""Subsets of which the rim of a mask or picture cuts a part off."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.methods.grid_correlation import GridMatches
from shapemorph.methods.spline_pictures import DeformedPicture, ReferencePicture
from shapemorph.methods.subset_dic import PointGrid

LEAST_SHARE = 0.1  # of a subset: no match has less


def inside_share(
    reference: ReferencePicture,
    deformed: DeformedPicture,
    grid: PointGrid,
    found: GridMatches,
    *,
    radius: int,
) -> Floats:
    """(R, C) share of the pixels of each subset that count, on the side where fewer do."""
    there = np.rint(np.nan_to_num(found.position)).astype(np.int64)
    sides = ((reference, grid.points), (deformed, there))
    shares = [_share(side.counts, at + reference.pad, radius) for side, at in sides]
    return np.minimum(*shares)


def _share(
    counts: np.ndarray[tuple[int, int], np.dtype[np.int32]], at: Ints, radius: int
) -> Floats:
    """Share of pixels that count in squares about places (x, y) of a padded picture."""
    height, width = counts.shape
    left, right = (np.clip(at[..., 0] + each, 0, width - 1) for each in (-radius, radius + 1))
    top, bottom = (np.clip(at[..., 1] + each, 0, height - 1) for each in (-radius, radius + 1))
    inside = counts[bottom, right] - counts[top, right] - counts[bottom, left] + counts[top, left]
    return np.asarray(inside / float((2 * radius + 1) ** 2))


def cut_noise(share: Floats) -> Floats:
    """Tell how many times the random error of a whole subset one with a share of its pixels has.

    Fewer pixels count, and the centre lies to one side of them, so that the slope, too,
    has a say: a straight line fitted to s of a width has the variance
    (1 + 3 ((1 - s) / s)^2) / s at the middle of the whole, in units of that of the whole.
    """
    s = np.clip(share, LEAST_SHARE, 1.0)
    return np.asarray(np.sqrt((1.0 + 3.0 * ((1.0 - s) / s) ** 2) / s))
