"""Subsets that were matched, read again to ask what the match has left."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys, Ints
from shapemorph.kernels.subset_samples import sample_subsets, weigh_subsets
from shapemorph.kernels.vectors import LANES
from shapemorph.methods.spline_pictures import DeformedPicture, ReferencePicture

BLOCK = 256  # subsets that a thread reads at once: few enough to stay in its cache
MAX_LAG = 3  # px; resampling correlates noise no farther unless it magnifies


@dataclass(frozen=True, slots=True, eq=False)
class MatchedSubsets:
    """Matched subsets: where they are, how they are warped, in which pictures.

    Attributes
    ----------
    reference, deformed : ReferencePicture, DeformedPicture
    points : (N, 2) int64
        Centres in the padded reference picture, px.
    warps : (N, 12)
    radius : int
        px.
    """

    reference: ReferencePicture
    deformed: DeformedPicture
    points: Ints
    warps: Floats
    radius: int

    @classmethod
    def at(
        cls,
        pictures: tuple[ReferencePicture, DeformedPicture],
        points: Ints,
        warps: Floats,
        chosen: Bools,
        radius: int,
    ) -> "MatchedSubsets":
        """Take the chosen points of a grid (R, C, ...)."""
        reference, deformed = pictures
        at = np.ascontiguousarray(points[chosen] + reference.pad)
        return cls(reference, deformed, at, np.ascontiguousarray(warps[chosen]), radius)

    def weights(self, first: int, last: int) -> Greys:
        """Tell which pixels of some subsets count in both pictures.

        Returns
        -------
        (last - first, 2 radius + 1, L) float32
            1 or 0; L is a multiple of LANES, with MAX_LAG columns of zeros at least.
        """
        width = 2 * self.radius + 1
        lanes = -(-(width + MAX_LAG) // LANES) * LANES
        weights = np.zeros((last - first, width, lanes), dtype=np.float32)
        weigh_subsets(
            self.reference.inside,
            self.reference.counts,
            self.deformed.inside,
            self.deformed.counts,
            self.points[first:last],
            self.warps[first:last],
            self.radius,
            weights,
        )
        return weights

    def samples(self, first: int, last: int) -> tuple[Greys, Greys]:
        """Weights of some subsets, and the deformed grey at their pixels, of the same shape."""
        weights = self.weights(first, last)
        grey = np.zeros_like(weights)
        sample_subsets(
            self.deformed.coefficients,
            self.deformed.wide,
            self.points[first:last],
            self.warps[first:last],
            self.radius,
            weights,
            grey,
        )
        return weights, grey
