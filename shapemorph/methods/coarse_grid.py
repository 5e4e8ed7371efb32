"""A grid of points on the middle of a morph sequence, carried outwards to both its ends."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.methods.grid_correlation import Limits
from shapemorph.methods.morph_sequence import origins_of_points
from shapemorph.methods.paper_dic import SearchSettings, peak_shifts
from shapemorph.methods.sequence_turn import NO_TURN, Turn
from shapemorph.methods.spline_pictures import prepare_reference
from shapemorph.methods.subset_dic import SubsetSettings, grid_points

LEAST_INSIDE = 0.5  # of a subset


@dataclass(frozen=True, slots=True, eq=False)
class Middle:
    """Points matched between the two pictures in the middle.

    Attributes
    ----------
    early, late : (P, 2) float64
        In the last picture of the early half and the first of the late half, px.
    settings : SearchSettings
        How they were searched.
    """

    early: Floats
    late: Floats
    settings: SearchSettings


def search_middle(
    pictures: Sequence[GreyImage],
    *,
    search: int,
    subset_size: int,
    spacing: int,
    least_zncc: float,
) -> Middle:
    """Search a regular grid on the middle picture of a sequence in the next one.

    Parameters
    ----------
    pictures : sequence of N GreyImage
        N even, of one size.
    search : int
        Width of the window in which a subset is sought, odd, px.
    subset_size, spacing : int
        px.
    least_zncc : float
        Less alike is not found.
    """
    subset = SubsetSettings(
        radius=subset_size // 2,
        order=0,
        tolerance=1.0,
        max_iterations=1,
        min_inside=LEAST_INSIDE,
        max_drift=float(search),
    )
    settings = SearchSettings(subset, Limits(least_zncc, 1.0), search)
    half = len(pictures) // 2
    grid = grid_points(pictures[half - 1].mask, spacing=spacing)
    points = grid.points[grid.inside].astype(np.float64)
    there, found = _step(pictures[half - 1], pictures[half], points, settings)
    return Middle(points[found], there[found], settings)


def carry_by_search(pictures: Sequence[GreyImage], middle: Middle) -> Floats:
    """Carry both sides outwards by search from picture to picture, (P, 2, 2).

    Peaks are taken between pixels: whole ones err alike on every step, and their errors add
    up to more than a subset starts from. Points that are lost on the way are left out.
    """
    half = len(pictures) // 2
    ends = [middle.early, middle.late]
    for side, order in ((0, pictures[half - 1 :: -1]), (1, pictures[half:])):
        for here, there in pairwise(order):
            moved, found = _step(here, there, ends[side], middle.settings)
            ends[side] = moved
            ends = [end[found] for end in ends]
    return np.stack(ends, axis=1)


def carry_by_warp(
    middle: Middle, warps: tuple[Warp, Warp], *, images: int, turn: Turn = NO_TURN
) -> Floats:
    """Carry both sides outwards as the pictures themselves were moved, exactly, (P, 2, 2).

    Parameters
    ----------
    middle : Middle
    warps : two Warp
        Forward and backward, of the whole way.
    images : int
        Synthetic pictures, N - 2.
    turn : Turn
        That the pictures were turned by on the whole way.
    """
    fraction = 0.5 if images else 0.0
    first = origins_of_points(middle.early, warps[0], fraction, turn)
    last = origins_of_points(middle.late, warps[1], fraction, turn.back)
    known = np.isfinite(first).all(axis=1) & np.isfinite(last).all(axis=1)
    return np.stack([first[known], last[known]], axis=1)


def _step(
    here: GreyImage, there: GreyImage, points: Floats, settings: SearchSettings
) -> tuple[Floats, Bools]:
    """Positions (P, 2) in the next picture, and which were found."""
    whole = np.rint(points).astype(np.int64)
    height, width = here.shape
    inside: Bools = np.asarray(((whole >= 0) & (whole < (width, height))).all(axis=1))
    reference = prepare_reference(here, allowed=None, pad=settings.subset.pad)
    shift, likeness = peak_shifts(reference, there, np.where(inside[:, None], whole, 0), settings)
    alike = np.isfinite(shift).all(axis=1) & (likeness >= settings.limits.min_zncc)
    return points + shift, inside & alike
