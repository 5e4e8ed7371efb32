"""Correlation of a whole grid from seeds that are searched: the most reliable goes first."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.image import GreyImage
from shapemorph.core.status import PointStatus
from shapemorph.methods.grid_correlation import (
    GridMatches,
    empty_matches,
    judged_matches,
    merged_matches,
    rescued_matches,
)
from shapemorph.methods.paper_dic import SearchSettings, whole_pixel_shifts
from shapemorph.methods.spline_pictures import DeformedPicture, ReferencePicture
from shapemorph.methods.subset_dic import (
    PointGrid,
    SubsetSettings,
    affine_starts,
    judge_zncc,
    match_points,
)

STRIDES = (8, 4, 2, 1)  # points between seeds; what none of them reached is searched more finely
NEIGHBOURS = [(r, c) for r in (-1, 0, 1) for c in (-1, 0, 1) if (r, c) != (0, 0)]


def correlate_from_seeds(
    reference: ReferencePicture,
    deformed: DeformedPicture,
    moved: GreyImage,
    grid: PointGrid,
    *,
    settings: SearchSettings,
) -> GridMatches:
    """Match all points of a grid that are inside, without any knowledge of where they went.

    Seeds spread over the grid are searched by whole pixels and matched. From there the
    points next to matched ones start with the affine map of the most alike neighbour, those
    with the most alike neighbours first. Where that ends, more seeds are searched among the
    points that were not reached, so that islands get their own. Then all are checked.

    Parameters
    ----------
    reference, deformed : ReferencePicture, DeformedPicture
        Padded by ``settings.subset.pad``.
    moved : GreyImage
        The deformed picture itself, of the shape of the reference.
    grid : PointGrid
    settings : SearchSettings

    References
    ----------
    B. Pan, "Reliability-guided digital image correlation for image deformation
    measurement", Applied Optics 48 (2009), doi:10.1364/AO.48.001535.
    """
    subset, limits = settings.subset, settings.limits
    spread = _Spread(reference, deformed, grid, subset, limits.min_zncc)
    found = empty_matches(grid)
    rows, cols = np.indices(grid.inside.shape)
    for stride in STRIDES:
        here = (rows % stride == stride // 2) & (cols % stride == stride // 2)
        seeds = np.argwhere(grid.inside & ~found.ok & here)
        at = grid.points[tuple(seeds.T)]
        shift, likeness = whole_pixel_shifts(reference, moved, at, settings)
        alike = likeness >= limits.min_zncc
        flat = np.broadcast_to(np.eye(2), (int(np.count_nonzero(alike)), 2, 2))
        found = spread.match(found, seeds[alike], at[alike] + shift[alike], flat)
        found = spread.on(found)
    found = judged_matches(found, grid.spacing, limits)
    return rescued_matches(reference, deformed, grid, found, settings=subset, limits=limits)


class _Spread:
    """Matching of points that start from their neighbours."""

    def __init__(
        self,
        reference: ReferencePicture,
        deformed: DeformedPicture,
        grid: PointGrid,
        settings: SubsetSettings,
        min_zncc: float,
    ) -> None:
        self._pictures = reference, deformed
        self._grid, self._settings, self._min_zncc = grid, settings, min_zncc
        self._tried = np.full(grid.inside.shape, -np.inf)  # likeness of the best start so far

    def match(
        self, found: GridMatches, chosen: Ints, position: Floats, gradient: Floats
    ) -> GridMatches:
        """Match some points from given starts."""
        if len(chosen) == 0:
            return found
        at = self._grid.points[tuple(chosen.T)]
        starts = affine_starts(at, position, gradient)
        matches = match_points(*self._pictures, at, starts, settings=self._settings)
        merged = merged_matches(found, matches, chosen)
        low = judge_zncc(merged.status, merged.zncc, min_zncc=self._min_zncc)
        merged.status[low == PointStatus.LOW_ZNCC] = PointStatus.LOW_ZNCC
        return merged

    def on(self, found: GridMatches) -> GridMatches:
        """Go on from what is matched until no neighbour is left that might do better."""
        while True:
            likeness, chosen, neighbour = self._frontier(found)
            if len(chosen) == 0:
                return found
            first = likeness >= np.median(likeness)
            chosen, neighbour = chosen[first], neighbour[first]
            self._tried[tuple(chosen.T)] = likeness[first]
            near = tuple(neighbour.T)
            step = (self._grid.points[tuple(chosen.T)] - self._grid.points[near]).astype(float)
            gradient = found.gradient[near]
            position = found.position[near] + np.einsum("nij,nj->ni", gradient, step)
            found = self.match(found, chosen, position, gradient)

    def _frontier(self, found: GridMatches) -> tuple[Floats, Ints, Ints]:
        """Unmatched points with a better neighbour than was tried, and that neighbour."""
        rows, cols = found.status.shape
        likeness = np.pad(np.where(found.ok, found.zncc, -np.inf), 1, constant_values=-np.inf)
        around = np.stack(
            [likeness[1 + r : 1 + r + rows, 1 + c : 1 + c + cols] for r, c in NEIGHBOURS]
        )
        best = around.max(axis=0)
        waiting: Bools = self._grid.inside & ~found.ok & (best > self._tried)
        chosen = np.argwhere(waiting)
        steps = np.array(NEIGHBOURS)[around.argmax(axis=0)[waiting]]
        return best[waiting], chosen, chosen + steps
