"""The slope of uncertain subsets from those beside them.

An affine subset finds its own slope. Where the pattern is uneven, or a rim cuts a part off,
an error of the slope moves the centre. The certain subsets around know the slope better.
"""

from dataclasses import replace

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.status import PointStatus
from shapemorph.methods.correlation_checks import neighbour_guesses
from shapemorph.methods.correlation_noise import displacement_covariance
from shapemorph.methods.grid_correlation import GridMatches
from shapemorph.methods.spline_pictures import DeformedPicture, ReferencePicture
from shapemorph.methods.subset_dic import (
    PointGrid,
    SubsetSettings,
    affine_starts,
    match_points,
)

UNCERTAIN, FULLY = 1.2, 2.0  # times the usual random error: another match counts a little, alone
STANDS_OUT = 1.5  # times the usual random error: far less certain than most
BY_CHANCE = 4.0  # random errors of the change: one that is larger has a reason
LEFT_OF_SLOPE = 0.7  # of what the slope alone adds to the error: neighbours overlap


def stands_out(covariance: Floats, *, by: float = STANDS_OUT) -> Bools:
    """Find the points (R, C) whose random error is so many times the usual one."""
    spread = np.trace(covariance, axis1=-2, axis2=-1)
    if not np.isfinite(spread).any():
        return np.zeros(spread.shape, dtype=bool)
    return np.asarray(spread > by**2 * np.nanmedian(spread))


def _share_of_another(covariance: Floats) -> Floats:
    """How much another match counts at each point (R, C), growing with its random error."""
    spread = np.sqrt(np.trace(covariance, axis1=-2, axis2=-1))
    share: Floats = (spread / np.nanmedian(spread) - UNCERTAIN) / (FULLY - UNCERTAIN)
    return np.clip(share, 0.0, 1.0)


def steady_slopes(
    reference: ReferencePicture,
    deformed: DeformedPicture,
    grid: PointGrid,
    found: GridMatches,
    covariance: Floats,
    *,
    settings: SubsetSettings,
) -> tuple[GridMatches, Floats]:
    """Match points that are less certain than most again, with the slope of the others.

    The change must be what chance explains: two estimates of one thing, of which one is the
    best there is, differ by the difference of their variances. Where they differ by more the
    slope does change, and the point stays as it was.

    Parameters
    ----------
    reference, deformed : ReferencePicture, DeformedPicture
    grid : PointGrid
    found : GridMatches
        Of first order.
    covariance : (R, C, 2, 2)
        Of the positions, px^2; NaN where not OK.
    settings : SubsetSettings
        With which they were matched.

    Returns
    -------
    GridMatches
    (R, C, 2, 2)
        Covariance of the positions.

    References
    ----------
    J. A. Hausman, "Specification tests in econometrics", Econometrica 46 (1978),
    doi:10.2307/1913827.
    """
    uncertain = found.ok & stands_out(covariance, by=UNCERTAIN)
    certain = found.ok & ~uncertain
    chosen = np.argwhere(uncertain)
    _, slope, known = neighbour_guesses(
        found.position, found.gradient, certain, chosen, spacing=grid.spacing
    )
    chosen, slope = chosen[known], slope[known]
    if len(chosen) == 0:
        return found, covariance
    place = tuple(chosen.T)
    at, stiff = grid.points[place], replace(settings, order=0)
    again = match_points(
        reference, deformed, at, affine_starts(at, found.position[place], slope), settings=stiff
    )
    warps = found.warps.copy()
    warps[place] = again.warps
    steadied = np.zeros_like(uncertain)
    steadied[place] = again.status == PointStatus.OK
    least = displacement_covariance(
        reference, deformed, grid.points, warps, steadied, settings=stiff
    )[place]
    added = np.maximum(np.diagonal(covariance[place] - least, axis1=-2, axis2=-1), 0.0)
    change = again.position - found.position[place]
    spreads = np.sqrt((change**2 / np.maximum(added, np.finfo(float).tiny)).max(axis=1))
    kept = steadied[place] & (spreads < BY_CHANCE)
    least += LEFT_OF_SLOPE**2 * added[:, None, :] * np.eye(2)
    credible = np.clip(2.0 - 2.0 * spreads / BY_CHANCE, 0.0, 1.0)
    share = (credible * _share_of_another(covariance)[place])[:, None]
    again = replace(again, position=found.position[place] + share * change)
    least = covariance[place] + share[:, :, None] * (least - covariance[place])
    place = tuple(chosen[kept].T)
    position, gradient = found.position.copy(), found.gradient.copy()
    zncc, covariance = found.zncc.copy(), covariance.copy()
    position[place], gradient[place] = again.position[kept], again.gradient[kept]
    zncc[place], covariance[place] = again.zncc[kept], least[kept]
    warps = np.where(steadied[..., None], warps, found.warps)
    warps[tuple(chosen[~kept].T)] = found.warps[tuple(chosen[~kept].T)]
    steady = replace(
        found,
        position=position,
        gradient=gradient,
        warps=warps,
        zncc=zncc,
        seconds=found.seconds + again.seconds,
    )
    return steady, covariance
