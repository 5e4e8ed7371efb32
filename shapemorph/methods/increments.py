"""Displacements from picture to picture, put together so that they refer to the first."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.matching import Warp
from shapemorph.core.status import PointStatus
from shapemorph.methods.grid_smoothing import fill_gaps
from shapemorph.methods.morph_sequence import origins_of_points
from shapemorph.methods.subset_dic import grid_points
from shapemorph.methods.warp_renewal import MARGIN, FoundGrid, renew_warp, spline_through

REACH = (0.3, 1.0)  # of the subset: over these lengths a warp through a grid averages
LEAST_NOISE = 1e-4  # px
LEAST_AREA = 1e-3  # px^2 that a px^2 of the reference becomes: no warp is to divide by less
COARSER = 2.0  # times the spacing of the knots of a warp
CORNERS = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])  # of a cell: column, row


@dataclass(frozen=True, slots=True, eq=False)
class _Cells:
    """Where positions lie in the grid of an increment.

    Attributes
    ----------
    column, row : (N, 4) int64
        Corners of the cell of each position.
    away : (N, 4, 2) float64
        From each corner to the position, px.
    weight : (N, 4) float64
        Bilinear; zero for corners without a value, else summing to one.
    whole : (N,) bool
        All corners have a value, or do not matter.
    """

    column: Ints
    row: Ints
    away: Floats
    weight: Floats
    whole: Bools


def compose_grids(
    first: CorrelationGrid, increment: CorrelationGrid, *, shown: Bools
) -> CorrelationGrid:
    """Carry the points of a grid on, from the picture where they are into the next one.

    Between the points of the increment its displacement is read from the values and
    gradients at the corners of the cell: exact for quadratic fields. Where a corner has no
    value the others are used, which are no farther than the spacing: the position lies
    inside their subsets, so that nothing is extrapolated.

    Parameters
    ----------
    first : CorrelationGrid
        First picture -> picture k.
    increment : CorrelationGrid
        Picture k -> next picture, on a grid of picture k.
    shown : (H, W) bool
        Where the next picture shows anything: a point that goes elsewhere is lost.

    Returns
    -------
    CorrelationGrid
        First picture -> next picture, on the grid of `first`. ZNCC and iterations are those
        of the increment; random errors add as variances. A point that was lost keeps its
        status; one whose surroundings are lost in the increment takes theirs.
    """
    known = first.status == PointStatus.OK
    at = first.deformed_px[known]
    cells = _locate(increment, at)
    positions = _positions(increment, cells)
    found = (cells.weight.sum(axis=1) > 0) & _on_mask(shown, positions)
    gradient = _blend(increment.gradient, cells)
    carried = gradient @ first.covariance_px2[known] @ np.swapaxes(gradient, 1, 2)
    covariance = carried + _blend(increment.covariance_px2, cells)
    nearest = _nearest(increment, at)
    reason = np.where(
        np.isin(increment.status[nearest], (PointStatus.OK, PointStatus.OUTSIDE_MASK)),
        np.uint8(PointStatus.LEFT_IMAGE),
        increment.status[nearest],
    )
    status = first.status.copy()
    status[known] = np.where(found, np.uint8(PointStatus.OK), reason)
    return CorrelationGrid(
        reference_px=first.reference_px,
        deformed_px=_spread(first, known, found, positions),
        gradient=_spread(first, known, found, gradient @ first.gradient[known]),
        zncc=_spread(first, known, found, _blend(increment.zncc, cells)),
        iterations=_iterations(first, known, increment.iterations[nearest]),
        sigma_px=_spread(first, known, found, np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))),
        status=status,
        spacing=first.spacing,
        subset_size=first.subset_size,
        kernel_seconds=increment.kernel_seconds,
        bias_px=_carried_bias(first, increment, cells, gradient, found),
        shared_px2=_spread(first, known, found, covariance[:, 0, 1]),
    )


def _carried_bias(
    first: CorrelationGrid,
    increment: CorrelationGrid,
    cells: _Cells,
    gradient: Floats,
    found: Bools,
) -> Floats | None:
    """Systematic errors of both steps, added in the last picture."""
    if first.bias_px is None or increment.bias_px is None:
        return None
    known = first.status == PointStatus.OK
    carried = np.einsum("nij,nj->ni", gradient, first.bias_px[known])
    added = _blend(increment.bias_px, cells)
    added[_blend(np.isnan(increment.bias_px), cells) > 0] = np.nan
    return _spread(first, known, found, carried + added)


def lost_grid(
    mask: Bools, *, spacing: int, subset_size: int, status: PointStatus
) -> CorrelationGrid:
    """Make the grid over a mask (H, W) on which no point was found."""
    grid = grid_points(mask, spacing=spacing)
    shape = grid.inside.shape
    return CorrelationGrid(
        reference_px=grid.points.astype(np.float64),
        deformed_px=np.full((*shape, 2), np.nan),
        gradient=np.full((*shape, 2, 2), np.nan),
        zncc=np.full(shape, np.nan),
        iterations=np.zeros(shape, dtype=np.int64),
        sigma_px=np.full((*shape, 2), np.nan),
        status=np.where(grid.inside, status, PointStatus.OUTSIDE_MASK).astype(np.uint8),
        spacing=spacing,
        subset_size=subset_size,
        kernel_seconds=0.0,
    )


def warp_through(grid: CorrelationGrid, base: Warp) -> Warp:
    """Fit a smooth warp to a grid; where it has no values, it goes on like `base`."""
    (along_x, shear_x), (shear_y, along_y) = np.moveaxis(grid.gradient, (-2, -1), (0, 1))
    magnified = np.abs(along_x * along_y - shear_x * shear_y)  # LAPACK warns of NaN
    noise = np.sqrt((grid.sigma_px**2).mean(axis=-1) / np.maximum(magnified, LEAST_AREA))
    noise = np.maximum(noise, LEAST_NOISE)
    reach = (REACH[0] * grid.subset_size, REACH[1] * grid.subset_size)
    points = np.rint(grid.reference_px).astype(np.int64)
    found = FoundGrid(points, grid.deformed_px, noise, grid.spacing)
    return renew_warp(base, found, reach=reach)


def continued(increment: CorrelationGrid, warp: Warp, shape: tuple[int, int]) -> Warp:
    """Foresee the next step: every point moves on as it has just moved.

    Parameters
    ----------
    increment : CorrelationGrid
        Last picture but one -> last picture.
    warp : Warp
        Through it, see :func:`warp_through`.
    shape : (int, int)
        Height and width of the last picture.

    Returns
    -------
    Warp
        Last picture -> next picture. Where no matched point has come from, the affine motion of
        all is followed, and what neighbours add to it.
    """
    spacing = COARSER * warp.spacing
    columns, rows = (np.arange(-MARGIN, size / spacing + MARGIN) for size in shape[::-1])
    here = spacing * np.stack(np.meshgrid(columns, rows), axis=-1)
    before = origins_of_points(here.reshape(-1, 2), warp, 1.0)
    found: Bools = np.asarray(np.isfinite(before).all(axis=-1))
    found[found] = _is_matched(increment, before[found])
    known, before = found.reshape(here.shape[:2]), before.reshape(here.shape)
    terms = np.concatenate([here, np.ones((*known.shape, 1))], axis=-1)
    common = terms @ np.linalg.lstsq(terms[known], (here - before)[known])[0]
    own = fill_gaps(here - before - common, known)
    return Warp(spline_through(here + common + own), here[0, 0], spacing)


def _is_matched(grid: CorrelationGrid, at: Floats) -> Bools:
    """Tell which places lie beside a grid point that was matched."""
    row, column = _nearest(grid, at)
    away = np.abs(at - grid.reference_px[row, column]).max(axis=1)
    return np.asarray((grid.status[row, column] == PointStatus.OK) & (away <= grid.spacing))


def _locate(grid: CorrelationGrid, at: Floats) -> _Cells:
    size = np.array(grid.status.shape[::-1])
    place = (at - grid.reference_px[0, 0]) / grid.spacing
    cell = np.clip(np.floor(place).astype(np.int64), 0, np.maximum(size - 2, 0))
    share = place - cell
    corner = np.minimum(cell[:, None] + CORNERS, size - 1)
    column, row = corner[..., 0], corner[..., 1]
    factors = np.where(CORNERS == 1, share[:, None], 1.0 - share[:, None])
    weight = factors.prod(axis=-1)
    away = at[:, None] - grid.reference_px[row, column]
    near = np.abs(away).max(axis=-1) <= grid.spacing
    matters = np.abs(weight) > 1e-9
    sound = (grid.status[row, column] == PointStatus.OK) & near
    inside = ((place >= -1e-9) & (place <= size - 1 + 1e-9)).all(axis=1)
    whole = inside & (sound | ~matters).all(axis=1)
    # off the grid, or beside a lost corner: the nearer of the others count more
    closeness = 1.0 / (1.0 + (away**2).sum(axis=-1))
    weight = np.where(whole[:, None], weight, closeness)
    weight = np.where(sound & (matters | ~whole[:, None]), weight, 0.0)
    total = weight.sum(axis=1, keepdims=True)
    return _Cells(column, row, away, weight / np.where(total > 0, total, 1.0), whole)


def _positions(grid: CorrelationGrid, cells: _Cells) -> Floats:
    """Where positions went: cubic from corner to corner, or continued from some of them."""
    matched = np.nan_to_num(grid.deformed_px[cells.row, cells.column])
    slope = np.nan_to_num(grid.gradient[cells.row, cells.column])
    expanded = matched + np.einsum("nkij,nkj->nki", slope, cells.away)
    both = np.where(cells.whole[:, None, None], (matched + expanded) / 2, expanded)
    positions: Floats = np.einsum("nk,nki->ni", cells.weight, both)
    return positions


def _on_mask(mask: Bools, at: Floats) -> Bools:
    """Whether the nearest pixel of each position lies on a mask."""
    place = np.rint(at).astype(np.int64)
    size = np.array(mask.shape[::-1])
    inside = ((place >= 0) & (place < size)).all(axis=1)
    column, row = np.clip(place, 0, size - 1).T
    return np.asarray(inside & mask[row, column])


def _blend(values: Floats, cells: _Cells) -> Floats:
    """Weighted mean of (R, C, ...) values over the corners, (N, ...)."""
    mean: Floats = np.einsum(
        "nk,nk...->n...", cells.weight, np.nan_to_num(values[cells.row, cells.column])
    )
    return mean


def _nearest(grid: CorrelationGrid, at: Floats) -> tuple[Ints, Ints]:
    """Row and column of the grid point nearest to each position."""
    place = np.rint((at - grid.reference_px[0, 0]) / grid.spacing).astype(np.int64)
    size = np.array(grid.status.shape[::-1])
    column, row = np.clip(place, 0, size - 1).T
    return row, column


def _spread(first: CorrelationGrid, known: Bools, found: Bools, values: Floats) -> Floats:
    """Put values (N, ...) back into the grid (R, C, ...); NaN where nothing was found."""
    whole = np.full((*first.status.shape, *values.shape[1:]), np.nan)
    values = values.copy()
    values[~found] = np.nan
    whole[known] = values
    return whole


def _iterations(first: CorrelationGrid, known: Bools, iterations: Ints) -> Ints:
    whole = np.zeros_like(first.iterations)
    whole[known] = iterations
    return whole
