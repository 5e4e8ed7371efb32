"""Forward-backward check of matches in doubt: what was matched must lead back to its start."""

from collections.abc import Callable

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.status import PointStatus
from shapemorph.methods.grid_correlation import GridMatches
from shapemorph.methods.spline_pictures import DeformedPicture, ReferencePicture
from shapemorph.methods.subset_dic import PointGrid, SubsetSettings, affine_starts, match_points

UNLIKE = 5.0  # times the usual lack of correlation puts a match in doubt, unless it is ...
ALIKE = 0.99  # ... good enough in any picture
CONTRADICTED = (PointStatus.OUTLIER, PointStatus.LOW_ZNCC, PointStatus.NOT_CONVERGED)
UNJUDGED = (PointStatus.LEFT_IMAGE, PointStatus.LOW_CONTRAST)  # the way back has too little to see
ALLOWED = 0.15  # px: a point may come back so far from its start, ...
SPREADS = 5.0  # ... or so many times the random error of one way

Reversed = Callable[[], tuple[ReferencePicture, DeformedPicture]]


def doubtful_matches(found: GridMatches) -> Bools:
    """Find matches that are clearly less alike than most, or lie beside one that failed.

    Returns
    -------
    (R, C) bool
        Only where OK.
    """
    import cv2

    ok = found.ok
    if not ok.any():
        return ok
    limit = min(1.0 - UNLIKE * (1.0 - float(np.median(found.zncc[ok]))), ALIKE)
    failed = np.isin(found.status, CONTRADICTED).astype(np.uint8)
    beside = cv2.dilate(failed, np.ones((3, 3), np.uint8)) > 0
    return np.asarray(ok & (beside | ~(found.zncc >= limit)))


def lost_on_return(
    backwards: Reversed,
    grid: PointGrid,
    found: GridMatches,
    noise: Floats,
    *,
    settings: SubsetSettings,
) -> Bools:
    """Match doubtful points back from where they went, and tell which do not return.

    The subset around the pixel that is nearest to the match is sought in the reference, from
    where the match itself says that it came from. Where too little of it can be seen there is
    no verdict. Without a point in doubt nothing is matched.

    Parameters
    ----------
    backwards : callable
        Makes the two pictures ready with their roles exchanged; only called where it takes.
    grid : PointGrid
    found : GridMatches
    noise : (R, C)
        Rough random error of a component, px.
    settings : SubsetSettings
        With which they were matched.

    Returns
    -------
    (R, C) bool
    """
    doubtful = doubtful_matches(found)
    lost = np.zeros_like(doubtful)
    if not doubtful.any():
        return lost
    reference, deformed = backwards()
    position, gradient = found.position[doubtful], found.gradient[doubtful]
    at = np.rint(position).astype(np.int64)
    size = np.array(reference.inside.shape[::-1]) - 2 * reference.pad
    seen = ((at >= 0) & (at < size)).all(axis=1) & (np.abs(np.linalg.det(gradient)) > 1e-3)
    at, position, gradient = at[seen], position[seen], gradient[seen]
    back = np.linalg.inv(gradient)
    expected = grid.points[doubtful][seen] + np.einsum("nij,nj->ni", back, at - position)
    match = match_points(
        reference, deformed, at, affine_starts(at, expected, back), settings=settings
    )
    off = np.linalg.norm(match.position - expected, axis=1)
    astray = off > np.maximum(ALLOWED, SPREADS * noise[doubtful][seen])
    failed = ~np.isin(match.status, (PointStatus.OK, *UNJUDGED))
    verdict = np.zeros(int(doubtful.sum()), dtype=bool)
    verdict[seen] = failed | (astray & (match.status == PointStatus.OK))
    lost[doubtful] = verdict
    return lost
