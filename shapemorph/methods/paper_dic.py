"""Correlation as the paper does it: whole pixels first, then affine maps by quadratic models."""

import time
from dataclasses import dataclass, replace

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.image import GreyImage
from shapemorph.kernels.ncc_affine import refine_affine
from shapemorph.kernels.vectors import LANES
from shapemorph.kernels.zncc import search
from shapemorph.methods.grid_correlation import (
    GridMatches,
    Limits,
    empty_matches,
    judged_matches,
    merged_matches,
)
from shapemorph.methods.spline_pictures import (
    DeformedPicture,
    ReferencePicture,
    shrink,
)
from shapemorph.methods.subset_dic import (
    PointGrid,
    SubsetMatches,
    SubsetSettings,
    affine_starts,
)
from shapemorph.methods.threads import run_blocks

BLOCK = 64  # points that a thread takes at once
LEAST_NEIGHBOURS = 3  # that an affine first guess takes
COLLINEAR = 1e-6  # of the product of the spreads: neighbours on a line tell no affine map


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """How subsets are searched by whole pixels and then matched.

    Attributes
    ----------
    subset : SubsetSettings
        Of the match; the paper's order is 1.
    limits : Limits
    search : int
        Width of the window in which the whole-pixel search looks for the subset, px.
    """

    subset: SubsetSettings
    limits: Limits
    search: int


def correlate_like_paper(
    reference: ReferencePicture,
    deformed: DeformedPicture,
    moved: GreyImage,
    grid: PointGrid,
    *,
    settings: SearchSettings,
    starts: Floats | None = None,
) -> GridMatches:
    """Match all points of a grid that are inside, coarsely, then finely.

    Coarse: zero-order subset, best zero-mean normalised cross-correlation among whole
    pixels. Fine: affine subset, first guess by least squares over the coarse matches of the
    point and its eight neighbours. Nothing is tried again.

    Parameters
    ----------
    reference, deformed : ReferencePicture, DeformedPicture
        Padded by ``settings.subset.pad``.
    moved : GreyImage
        The deformed picture itself, of the shape of the reference.
    grid : PointGrid
    settings : SearchSettings
    starts : (N, 12) or None
        First guesses of the points inside, row by row, that stand for the coarse matches.

    References
    ----------
    Genovese, Sorgente (2017), method (i), Eq. 1-2, doi:10.1016/j.optlaseng.2017.06.020.
    """
    start = time.perf_counter()
    if starts is None:
        chosen, starts = _coarse(reference, moved, grid, settings)
    else:
        chosen = np.argwhere(grid.inside)
    place = tuple(chosen.T)
    fine = _fine(reference, deformed, grid.points[place], starts, settings.subset)
    found = merged_matches(empty_matches(grid), fine, chosen)
    found = judged_matches(found, grid.spacing, settings.limits)
    return replace(found, seconds=time.perf_counter() - start)


def _coarse(
    reference: ReferencePicture, moved: GreyImage, grid: PointGrid, settings: SearchSettings
) -> tuple[Ints, Floats]:
    """Rows and columns (M, 2) of the points that have a first guess, and these (M, 12)."""
    alike = np.zeros(grid.inside.shape, dtype=bool)
    shift = np.zeros((*alike.shape, 2))
    shift[grid.inside], likeness = whole_pixel_shifts(
        reference, moved, grid.points[grid.inside], settings
    )
    alike[grid.inside] = likeness >= settings.limits.min_zncc
    guess, slope, known = first_guesses(grid, shift, alike)
    chosen = np.argwhere(grid.inside & known)
    place = tuple(chosen.T)
    return chosen, affine_starts(grid.points[place], guess[place], slope[place])


def first_guesses(grid: PointGrid, shift: Floats, usable: Bools) -> tuple[Floats, Floats, Bools]:
    """Guess affine maps by least squares over each point and its eight neighbours.

    Parameters
    ----------
    grid : PointGrid
    shift : (R, C, 2)
        Displacements, px.
    usable : (R, C) bool
        Points that have one.

    Returns
    -------
    position : (R, C, 2)
        Where the point went, px.
    gradient : (R, C, 2, 2)
    known : (R, C) bool
        Where three usable points or more, not on a line, told it.
    """
    weight = np.pad(usable, 1).astype(np.float64)
    values = np.pad(np.where(usable[..., None], shift, 0.0), ((1, 1), (1, 1), (0, 0)))
    rows, cols = usable.shape
    matrix, right = np.zeros((rows, cols, 3, 3)), np.zeros((rows, cols, 3, 2))
    for down in (-1, 0, 1):
        for across in (-1, 0, 1):
            some = np.s_[1 + down : 1 + down + rows, 1 + across : 1 + across + cols]
            terms = np.array([1.0, across, down])
            matrix += weight[some][..., None, None] * np.outer(terms, terms)
            right += terms[:, None] * (weight[some][..., None] * values[some])[..., None, :]
    known = (matrix[..., 0, 0] >= LEAST_NEIGHBOURS) & (np.linalg.det(matrix) > COLLINEAR)
    matrix[~known] = np.eye(3)
    fit = np.linalg.solve(matrix, right)
    gradient = np.eye(2) + np.swapaxes(fit[..., 1:, :], -1, -2) / grid.spacing
    return grid.points + fit[..., 0, :], gradient, known


def whole_pixel_shifts(
    reference: ReferencePicture, moved: GreyImage, points: Ints, settings: SearchSettings
) -> tuple[Floats, Floats]:
    """Search subsets by whole pixels; as :func:`peak_shifts`, rounded."""
    shift, likeness = peak_shifts(reference, moved, points, settings)
    return np.rint(shift), likeness


def peak_shifts(
    reference: ReferencePicture, moved: GreyImage, points: Ints, settings: SearchSettings
) -> tuple[Floats, Floats]:
    """Search subsets by whole pixels; a quadratic surface tells the peak between them.

    Parameters
    ----------
    reference : ReferencePicture
    moved : GreyImage
        The deformed picture, of the shape of the reference.
    points : (N, 2)
        Centres (x, y), px.
    settings : SearchSettings

    Returns
    -------
    shift : (N, 2)
        px; NaN where none was found or the best lies at the edge of the search.
    likeness : (N,)
        Zero-mean normalised cross-correlation there.
    """
    pad, subset = reference.pad, settings.subset
    whole = np.s_[pad:-pad, pad : -pad - LANES]
    still_mask = np.ascontiguousarray(reference.inside[whole])
    moved_mask = shrink(moved.mask).astype(np.float32)
    centre = np.float32(moved.grey[moved.mask].mean())  # float32 sums lose less about zero
    furthest = (settings.search - 2 * subset.radius - 1) // 2
    found = search(
        (reference.planes[0][whole] - centre) * still_mask,
        still_mask,
        (moved.grey - centre) * moved_mask,
        moved_mask,
        np.ascontiguousarray(points),
        subset.radius,
        furthest + 1,  # a best shift at the edge of the search does not count
        1,
        subset.min_inside,
    )
    return found[:, :2], found[:, 2]


def _fine(
    reference: ReferencePicture,
    deformed: DeformedPicture,
    points: Ints,
    starts: Floats,
    settings: SubsetSettings,
) -> SubsetMatches:
    at = np.ascontiguousarray(points + reference.pad)
    warps, number = np.array(starts, order="C"), len(at)
    zncc, iterations = np.full(number, np.nan), np.zeros(number, dtype=np.int64)
    status = np.zeros(number, dtype=np.uint8)

    def work(first: int, last: int) -> None:
        some = slice(first, last)
        refine_affine(
            reference.planes[0],
            reference.inside,
            deformed.coefficients,
            deformed.inside,
            at[some],
            settings.radius,
            settings.tolerance,
            settings.max_iterations,
            settings.min_count,
            settings.max_drift,
            warps[some],
            zncc[some],
            iterations[some],
            status[some],
        )

    run_blocks(work, number, block=BLOCK)
    position = points + warps[:, [0, 6]]
    gradient = warps[:, [1, 2, 7, 8]].reshape(-1, 2, 2)
    return SubsetMatches(position, gradient, warps, zncc, iterations, status, 0.0)
