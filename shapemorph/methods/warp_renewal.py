"""A warp renewed from what correlation found on a grid."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.matching import Warp
from shapemorph.methods.grid_smoothing import GridSmoother, bends, fill_gaps
from shapemorph.methods.warping import warp_points

SMOOTHING = (0.3, 1.0)  # of the subset: over these lengths a renewed warp averages the points
MARGIN = 6  # cells around the grid; the spline forgets its border by 0.27 per cell
AGAIN = 8  # times that a wide field is sought in what it has left, where that says more than noise
QUIET = 25.0  # percentile of the points at which most fields are smooth
QUIET_RAYLEIGH = 0.7585  # that percentile of the length of two unit normals
FRESH_NOISE = 0.3  # random errors: a difference by less is left as it was; it has no noise
AGAIN_NOISE = 0.55  # random errors that a difference has at most by noise alone
NARROW_NOISE = 1.5  # likewise
STANDS_OUT = 3.5  # times the noise of the difference
TINY = 1e-9  # keeps quotients finite
FEWEST = 15  # points: a smaller piece follows its neighbours

Box = tuple[slice, slice]


@dataclass(frozen=True, slots=True, eq=False)
class FoundGrid:
    """Where a regular grid of points went.

    Attributes
    ----------
    points : (R, C, 2) int64
        In the reference, px.
    deformed : (R, C, 2)
        px.
    noise : (R, C)
        Rough random error of a component of each point, > 0, px of the reference; NaN where
        the point is not to be trusted.
    spacing : int
        Of the grid, px.
    seen : (R, C, 3) or None
        What the subsets that found the points make of bending, px^2, see
        :func:`~shapemorph.methods.seen_bends.seen_bends`; None where the positions hold at
        the points themselves.
    whole : (R, C) bool or None
        Subsets that no rim cuts: they alone tell what is narrow. None for all.
    """

    points: Ints
    deformed: Floats
    noise: Floats
    spacing: int
    seen: Floats | None = None
    whole: Bools | None = None


@dataclass(frozen=True, slots=True, eq=False)
class _Knots:
    """The same on a grid with a margin, and the warp there."""

    before: Floats
    found: Floats
    noise: Floats
    seen: Floats
    whole: Bools

    def within(self, box: Box, piece: Bools) -> "_Knots":
        """Cut out a box, with the points of one piece alone."""
        noise = np.where(piece, self.noise, np.nan)[box]
        return _Knots(self.before[box], self.found[box], noise, self.seen[box], self.whole[box])


def renew_warp(warp: Warp, grid: FoundGrid, *, reach: tuple[float, float]) -> Warp:
    """Correct a warp by what a grid of points says, smoothed.

    What the points say beyond the warp is fitted around each of them by a quadratic surface
    with Gaussian weights. So the warp takes over the curvature of the field, which an affine
    subset cannot follow, but not the noise of single points: what varies within a subset is
    not measured again by the next correlation, it stays. Points that are less certain than
    most, as cut subsets are, weigh less, so that the warp does not bend with their noise
    where it runs out.

    A warp that bends where the field does not, as one of few features does, most beside
    rims, spoils what is found through it: subsets give positions that are off by what they
    cannot follow, one way or another as a rim cuts them. So the whole field is sought afresh
    as well: the bending of the warp, as the subsets saw it, is taken back; then the fit is
    applied to what it leaves until the subsets would have seen in the field what they saw;
    then, for kinks, a narrow fit. Each counts where it differs from the one before by more
    than noise makes it.

    Parameters
    ----------
    warp : Warp
        Reference -> deformed; the points were found through it. It goes on where there are
        none.
    grid : FoundGrid
    reach : (float, float)
        Standard deviation of the weights of the narrow and of the wide fit, px.
    """
    spacing = grid.spacing
    x = _lattice(grid.points[0, :, 0], spacing)
    y = _lattice(grid.points[:, 0, 1], spacing)
    places = np.stack(np.meshgrid(x, y), axis=-1)
    before = continue_warp(warp, places.reshape(-1, 2)).reshape(places.shape)
    knots = _laid_out(before, grid)
    known = np.isfinite(knots.noise)
    usual = float(np.median(knots.noise[known]))
    correction = np.zeros_like(before)
    in_points = (reach[0] / spacing, reach[1] / spacing)
    for box, piece, owned in _pieces(known, apart=in_points[1]):
        some = _correction(knots.within(box, piece), usual, in_points)
        correction[box] = np.where(owned[box][..., None], some, correction[box])
    return Warp(spline_through(before + correction), np.array([x[0], y[0]]), float(spacing))


def _laid_out(before: Floats, grid: FoundGrid) -> _Knots:
    """Lay the grid into one with a margin."""
    inner = (slice(MARGIN, -MARGIN), slice(MARGIN, -MARGIN))
    usable = np.isfinite(grid.noise)
    found, noise = before.copy(), np.full(before.shape[:2], np.nan)
    found[inner][usable] = grid.deformed[usable]
    noise[inner][usable] = grid.noise[usable] / grid.spacing
    seen = np.zeros((*noise.shape, 3))
    if grid.seen is not None:
        seen[inner] = grid.seen / grid.spacing**2
    whole = np.isfinite(noise)
    if grid.whole is not None:
        whole[inner] &= grid.whole
    return _Knots(before, found, noise, seen, whole)


def _pieces(known: Bools, *, apart: float) -> Iterator[tuple[Box, Bools, Bools]]:
    """Part the known points of a grid into pieces that lie apart, such as pages.

    Yields
    ------
    box : two slices
        The piece with a margin around it.
    piece, owned : (R, C) bool
        Its points, and the places nearer to it than to others.
    """
    from scipy.ndimage import binary_dilation, distance_transform_edt, find_objects, label

    square = np.ones((3, 3), dtype=bool)
    grown = binary_dilation(known, square, iterations=max(1, int(apart / 2)))
    labels, number = label(grown, square)
    labels[~known] = 0
    large = np.flatnonzero(np.bincount(labels.ravel(), minlength=number + 1)[1:] >= FEWEST) + 1
    if len(large) < 2:
        yield (slice(None), slice(None)), known, np.ones_like(known)
        return
    kept = np.isin(labels, large)
    at = distance_transform_edt(~kept, return_distances=False, return_indices=True)
    nearest = labels[tuple(at)]
    for which, found in enumerate(find_objects(labels), start=1):
        if which in large:
            box = tuple(slice(max(s.start - MARGIN, 0), s.stop + MARGIN) for s in found)
            yield (box[0], box[1]), labels == which, nearest == which


def _correction(knots: _Knots, usual: float, reach: tuple[float, float]) -> Floats:
    """(R, C, 2) what the points of one piece add to the warp."""
    known = np.isfinite(knots.noise)
    weight = np.where(known, np.minimum(usual / np.where(known, knots.noise, 1.0), 1.0) ** 2, 0.0)
    narrow, wide = (GridSmoother.over(weight, reach=each) for each in reach)
    added = fill_gaps(wide(knots.found - knots.before), wide.sound)
    for smoother, times, most, telling in (
        (wide, 0, FRESH_NOISE, known),
        (wide, AGAIN, AGAIN_NOISE, known),
        (narrow, 1, NARROW_NOISE, known & knots.whole),
    ):
        other = _sought(knots, smoother, times=times)
        added += _where_apart(other - added, knots, telling, most=most)
    return added


def _sought(knots: _Knots, smoother: GridSmoother, *, times: int) -> Floats:
    """(R, C, 2) fit of the whole field, less the warp, through what its subsets saw of it."""
    flat = _flat(knots.before)
    bent = knots.before - flat
    found = knots.found - flat + _seen_of(bent, knots.seen)
    added = fill_gaps(smoother(found) - bent, smoother.sound)
    for _ in range(times):
        added += smoother(found - bent - added - _seen_of(bent + added, knots.seen))
    return fill_gaps(added, smoother.sound)


def _where_apart(apart: Floats, knots: _Knots, telling: Bools, *, most: float) -> Floats:
    """Differences (R, C, 2) of two fits where they stand out of the noise of the points."""
    apart_there = _in_reference(apart, knots.before)
    share = _share_of_other(apart_there, knots.noise, telling, most=most)
    return fill_gaps(share[..., None] * apart, telling)


def _seen_of(field: Floats, seen: Floats) -> Floats:
    """(R, C, 2) how far the bending of a field moves what subsets find."""
    return np.asarray((bends(field) * seen[..., None, :]).sum(axis=-1))


def _flat(field: Floats) -> Floats:
    """Fit the plane through an (R, C, 2) field."""
    rows, columns = np.indices(field.shape[:2], dtype=np.float64)
    terms = np.stack([np.ones_like(rows), rows, columns], axis=-1).reshape(-1, 3)
    plane = terms @ np.linalg.lstsq(terms, field.reshape(-1, 2), rcond=None)[0]
    return np.asarray(plane.reshape(field.shape))


def _in_reference(change: Floats, targets: Floats) -> Floats:
    """Carry changes (R, C, 2) of the targets of a grid back into the reference, in cells.

    There random errors are alike in all directions. A stretch makes them longer along it.
    """
    along_rows, along_cols = (np.asarray(np.gradient(targets, axis=axis)) for axis in (0, 1))
    (xr, yr), (xc, yc) = np.moveaxis(along_rows, -1, 0), np.moveaxis(along_cols, -1, 0)
    x, y = np.moveaxis(change, -1, 0)
    area = np.maximum(np.abs(xc * yr - xr * yc), TINY)
    return np.stack([(yr * x - xr * y) / area, (xc * y - yc * x) / area], axis=-1)


def _share_of_other(apart: Floats, noise: Floats, telling: Bools, *, most: float) -> Floats:
    """(R, C) share of another fit: all where two fits lie apart by more than noise.

    One point is not asked alone: its own error is nearly all that a narrow fit shows.
    """
    share = np.zeros(telling.shape)
    if not telling.any():
        return share
    squares = np.zeros(telling.shape)
    squares[telling] = (apart[telling] ** 2).sum(axis=-1) / np.maximum(noise[telling], TINY) ** 2
    usual = min(np.sqrt(np.percentile(squares[telling], QUIET)) / QUIET_RAYLEIGH, most)
    squares = _around(squares, telling)
    share[telling] = 1.0 / (
        1.0 + ((STANDS_OUT * usual) ** 2 / np.maximum(squares[telling], TINY)) ** 3
    )
    return _around(share, telling)


def _around(values: Floats, known: Bools) -> Floats:
    """Average an (R, C) grid over the known points near each of them; 0 elsewhere."""
    from scipy.ndimage import gaussian_filter

    mean = np.zeros(known.shape)
    weight = gaussian_filter(known.astype(np.float64), 1.0)
    mean[known] = gaussian_filter(values, 1.0)[known] / weight[known]
    return mean


def continue_warp(warp: Warp, points: Floats) -> Floats:
    """(N, 2) targets of points, linearly continued beyond the warp's own extent."""
    size = np.array(warp.coefficients.shape[1::-1], dtype=np.float64)
    slack = 1e-6 * warp.spacing  # rounding must not carry a point over the border
    low = warp.origin + warp.spacing + slack
    high = warp.origin + warp.spacing * (size - 2.0) - slack
    nearest = np.clip(points, low, high)
    targets, gradient = warp_points(warp, nearest)
    return np.asarray(targets + np.einsum("nij,nj->ni", gradient, points - nearest))


def _lattice(along: Ints, spacing: int) -> Floats:
    before = np.arange(-MARGIN, len(along) + MARGIN)
    return np.asarray(along[0] + spacing * before, dtype=np.float64)


def spline_through(targets: Floats) -> Floats:
    """Coefficients of the spline through an (R, C, 2) grid of targets."""
    from scipy.ndimage import spline_filter

    parts = [spline_filter(np.ascontiguousarray(targets[..., k]), order=3) for k in range(2)]
    return np.stack([np.asarray(part, dtype=np.float64) for part in parts], axis=-1)
