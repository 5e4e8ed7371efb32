"""Where the centre of a subset has moved otherwise than its shape function says."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.kernels.subset_rest import rest_motion
from shapemorph.methods.matched_subsets import BLOCK, MatchedSubsets
from shapemorph.methods.spline_pictures import DeformedPicture, ReferencePicture
from shapemorph.methods.threads import run_blocks

FINE, WIDE = 0.2, 0.35  # standard deviations of weights about the centre, in radii of the subset
REACH = 3.0  # standard deviations that are looked at
CALM = 20.0  # percentile of the misfit that is taken for noise alone
FINEST = (0.3 / 255) ** 2  # noise of whole levels: no picture has less
SURE = 3.7  # standard deviations: a smaller motion is not told from noise
ODD = 2.0  # times the noise: so much is left where the subset moves in ways that are not followed


@dataclass(frozen=True, slots=True, eq=False)
class _Rest:
    """What is left near the centres of subsets: shift, its square in units of noise, excess."""

    shift: Floats
    squared_length: Floats
    noise: float
    misfit: Floats


def unfollowed_motion(
    reference: ReferencePicture,
    deformed: DeformedPicture,
    points: Ints,
    warps: Floats,
    usable: Bools,
    *,
    radius: int,
) -> Floats:
    """Find the motion at the centres of subsets that their shape function leaves.

    What a match has left of the grey is fitted by a shift about the centre, with narrow
    and with wider weights; the narrow one counts where it is told from noise, else the
    wide one. Where far more is left than noise the pattern moves within the subset by more
    than any shift shows: the motion then has the size that explains it.

    Parameters
    ----------
    reference, deformed : ReferencePicture, DeformedPicture
    points : (R, C, 2)
        Grid, px.
    warps : (R, C, 12)
        Subset warps.
    usable : (R, C) bool
        Points that were matched.
    radius : int
        Of the subset, px.

    Returns
    -------
    (R, C, 2)
        Truth - estimate, px of the deformed picture; zero where it is not told from noise,
        NaN where not usable.
    """
    subsets = MatchedSubsets.at((reference, deformed), points, warps, usable, radius)
    fine, wide = _rests(subsets, _windows(radius))
    shift = np.where((wide.squared_length > SURE**2)[:, None], wide.shift, 0.0)
    shift = np.where((fine.squared_length > SURE**2)[:, None], fine.shift, shift)
    shift = _lengthened(shift, fine, wide)
    slope = subsets.warps[:, [1, 2, 7, 8]].reshape(-1, 2, 2)
    result = np.full((*usable.shape, 2), np.nan)
    result[usable] = np.einsum("nij,nj->ni", slope, shift)
    return result


def _lengthened(shift: Floats, fine: _Rest, wide: _Rest) -> Floats:
    """Shifts with at least the size that explains what is left of whole subsets."""
    left, slopes = wide.misfit.T
    size = np.sqrt(np.maximum(left - wide.noise, 0.0) / np.maximum(slopes, 1e-12))
    length = np.hypot(*fine.shift.T)
    way = fine.shift / np.maximum(length, 1e-12)[:, None]
    short = (left > ODD * wide.noise) & (np.hypot(*shift.T) < size) & (length > 0)
    return np.where(short[:, None], size[:, None] * way, shift)


def _windows(radius: int) -> tuple[tuple[int, float], tuple[int, float]]:
    """Half widths and standard deviations of the narrow and of the wide weights, px."""
    return (int(np.ceil(REACH * FINE * radius)), FINE * radius), (radius, WIDE * radius)


def _rests(subsets: MatchedSubsets, windows: Sequence[tuple[int, float]]) -> list[_Rest]:
    """Fit shifts with weights of several widths to subsets that are read once."""
    number = len(subsets.points)
    shift, doubt = np.empty((len(windows), number, 2)), np.zeros((len(windows), number, 3))
    misfit = np.empty((len(windows), number, 2))

    def work(first: int, last: int) -> None:
        some = slice(first, last)
        weights, grey = subsets.samples(first, last)
        for n, (half, spread) in enumerate(windows):
            rest_motion(
                subsets.reference.planes,
                subsets.points[some],
                weights,
                grey,
                half,
                spread,
                shift[n, some],
                doubt[n, some],
                misfit[n, some],
            )

    run_blocks(work, number, block=BLOCK)
    return [_told(*each) for each in zip(shift, doubt, misfit, strict=True)]


def _told(shift: Floats, doubt: Floats, misfit: Floats) -> _Rest:
    """Hold shifts against the noise that the calmest subsets show."""
    left = misfit[np.isfinite(misfit[:, 0]), 0]
    noise = max(float(np.percentile(left, CALM)), FINEST) if len(left) else np.inf
    return _Rest(shift, _squared_length(shift, doubt * noise), noise, misfit)


def _squared_length(shift: Floats, variance: Floats) -> Floats:
    """(N,) squares of vectors in units of their standard deviation."""
    xx, yy, xy = variance.T
    det = np.maximum(xx * yy - xy * xy, 1e-300)
    x, y = shift.T
    return np.asarray((yy * x * x - 2.0 * xy * x * y + xx * y * y) / det)
