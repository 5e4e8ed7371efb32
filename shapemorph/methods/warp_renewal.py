"""A warp corrected by what correlation found on a grid."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.matching import Warp
from shapemorph.methods.warping import warp_points

SMOOTHING = (0.3, 1.0)  # of the subset: over these lengths a renewed warp averages the points
MARGIN = 6  # cells around the grid; the spline forgets its border by 0.27 per cell
TERMS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
RIDGE = 1e-6  # of the weight: keeps fits at rims and corners solvable
QUIET = 25.0  # percentile of the points at which most fields are smooth
QUIET_RAYLEIGH = 0.7585  # that percentile of the length of two unit normals
MOST_NOISE = 1.5  # difference of the two fits by noise alone, in rough random errors
STANDS_OUT = 3.5  # times the noise of the difference
ENOUGH = 0.05  # weight of measured points that a gap is filled from
COMPARED = 2.0  # widths of the wide fit: so far around a place fits are compared
TINY = 1e-9  # keeps quotients finite


def renew_warp(
    warp: Warp,
    points: Ints,
    deformed: Floats,
    noise: Floats,
    *,
    spacing: int,
    reach: tuple[float, float],
) -> Warp:
    """Correct a warp by what a grid of points says, smoothed.

    What the points say beyond the warp is fitted around each of them by a quadratic
    surface with Gaussian weights. So the warp takes over the curvature of the field,
    which an affine subset cannot follow, but not the noise of single points: what varies
    within a subset is not measured again by the next correlation, it stays. The fit is
    wide, and narrow where it differs from the wide one by more than noise: near kinks.
    Points that are less certain than most, as cut subsets are, weigh less, so that the warp
    does not bend with their noise where it runs out.

    Parameters
    ----------
    warp : Warp
        Reference -> deformed.
    points : (R, C, 2)
        Regular grid in the reference, px.
    deformed : (R, C, 2)
        Where the points went, px.
    noise : (R, C)
        Rough random error of a component of each point, > 0, px of the reference; NaN where
        the point is not to be trusted.
    spacing : int
        Of the grid, px.
    reach : (float, float)
        Standard deviation of the weights of the narrow and of the wide fit, px.
    """
    x = _lattice(points[0, :, 0], spacing)
    y = _lattice(points[:, 0, 1], spacing)
    knots = np.stack(np.meshgrid(x, y), axis=-1)
    before = continue_warp(warp, knots.reshape(-1, 2)).reshape(knots.shape)
    inner = (slice(MARGIN, -MARGIN), slice(MARGIN, -MARGIN))
    known = np.zeros(before.shape[:2], dtype=bool)
    usable = np.isfinite(noise)
    known[inner] = usable
    found = before.copy()
    found[inner][usable] = deformed[usable]
    level = np.zeros((*known.shape, 1))
    level[known, 0] = noise[usable]
    weight = np.zeros(known.shape)
    weight[known] = np.minimum(np.median(noise[usable]) / noise[usable], 1.0) ** 2
    narrow, wide = (each / spacing for each in reach)
    smooth = _smooth_correction(before, found, weight, seen=narrow, reach=wide)
    closer = fill_gaps(*smooth_quadratic(found - before, weight, reach=narrow)) - smooth
    share = _narrow_share(
        _in_reference(closer, before), fill_gaps(level, known)[..., 0] / spacing, known
    )
    target = before + smooth + share[..., None] * closer
    return Warp(spline_through(target), np.array([x[0], y[0]]), float(spacing))


def _smooth_correction(
    before: Floats, found: Floats, weight: Floats, *, seen: float, reach: float
) -> Floats:
    """(R, C, 2) smooth fit of what points found beyond the warp, or of all that they found.

    The first keeps details of the warp that the points would be too coarse to tell, the
    second is free of what a warp of few features has made up. Both are fits of one width, so
    that the squares of what is left over compare them: around each place they are mixed so
    that these are least. What is made up the points have seen as their subsets do, averaged
    over a Gaussian of `seen` cells; the rest of it they have as errors of their own.

    References
    ----------
    D. H. Wolpert, "Stacked generalization", Neural Networks 5 (1992),
    doi:10.1016/S0893-6080(05)80023-1.
    """
    from scipy.ndimage import gaussian_filter

    trend = _affine_trend(found, weight)
    both, sound = smooth_quadratic(
        np.concatenate([found - before, found - trend], axis=-1), weight, reach=reach
    )
    kept = fill_gaps(both[..., :2], sound)
    change = fill_gaps(both[..., 2:] + trend - before, sound) - kept
    apart, left = _in_reference(change, before), _in_reference(found - before - kept, before)
    apart = gaussian_filter(apart, (seen, seen, 0))
    gain, size = (
        gaussian_filter(weight * (apart * each).sum(axis=-1), COMPARED * reach)
        for each in (left, apart)
    )
    share = np.clip(gain / np.maximum(size, TINY**2), 0.0, 1.0)
    return np.asarray(kept + share[..., None] * change)


def _affine_trend(values: Floats, weight: Floats) -> Floats:
    """(R, C, 2) affine map of a grid that fits its values (R, C, 2) best."""
    rows, cols = np.indices(weight.shape, dtype=np.float64)
    terms = np.stack([np.ones_like(rows), cols, rows], axis=-1)
    root, chosen = np.sqrt(weight[weight > 0])[:, None], weight > 0
    map_ = np.linalg.lstsq(root * terms[chosen], root * values[chosen])[0]
    return np.asarray(terms @ map_)


def smooth_quadratic(values: Floats, weight: Floats, *, reach: float) -> tuple[Floats, Bools]:
    """Fit a quadratic surface around every point of a grid, with Gaussian weights.

    Parameters
    ----------
    values : (R, C, D)
    weight : (R, C)
        Of each value, from 0, where it is not known, to 1.
    reach : float
        Standard deviation of the Gaussian weights, in points.

    Returns
    -------
    smooth : (R, C, D)
        The surface at its own centre.
    sound : (R, C) bool
        Where known points lie on all sides, or near, so that the fit is one.
    """
    from scipy.ndimage import correlate1d

    offsets = np.arange(-int(np.ceil(3 * reach)), int(np.ceil(3 * reach)) + 1) / reach
    kernels = [np.exp(-0.5 * offsets**2) * offsets**n for n in range(5)]

    def moment(field: Floats, along_x: int, along_y: int) -> Floats:
        rows = correlate1d(field, kernels[along_x], axis=1, mode="constant")
        return np.asarray(correlate1d(rows, kernels[along_y], axis=0, mode="constant"))

    known = weight > 0
    table = {(a, b): moment(weight, a, b) for a in range(5) for b in range(5 - a)}
    normal = np.stack([[table[p[0] + q[0], p[1] + q[1]] for p in TERMS] for q in TERMS])
    normal = np.moveaxis(normal, (0, 1), (-2, -1))
    right = np.stack(
        [
            [moment(weight * np.where(known, values[..., k], 0.0), *p) for p in TERMS]
            for k in range(values.shape[-1])
        ]
    )
    right = np.moveaxis(right, (0, 1), (-1, -2))
    sound = table[0, 0] > ENOUGH * (kernels[0].sum() ** 2)
    smooth = np.zeros_like(values)
    ridge = RIDGE * table[0, 0][sound][:, None, None] * np.eye(len(TERMS))
    smooth[sound] = np.linalg.solve(normal[sound] + ridge, right[sound])[:, 0]
    return smooth, sound


def _in_reference(change: Floats, targets: Floats) -> Floats:
    """Carry changes (R, C, 2) of the targets of a grid back into the reference, in cells.

    There random errors are alike in all directions. A stretch makes them longer along it.
    """
    along_rows, along_cols = (np.asarray(np.gradient(targets, axis=axis)) for axis in (0, 1))
    (xr, yr), (xc, yc) = np.moveaxis(along_rows, -1, 0), np.moveaxis(along_cols, -1, 0)
    x, y = np.moveaxis(change, -1, 0)
    area = np.maximum(np.abs(xc * yr - xr * yc), TINY)
    return np.stack([(yr * x - xr * y) / area, (xc * y - yc * x) / area], axis=-1)


def _narrow_share(apart: Floats, noise: Floats, known: Bools) -> Floats:
    """(R, C) share of the narrow fit: all where both fits lie apart by more than noise.

    One point is not asked alone: its own error is nearly all that its narrow fit shows.
    """
    from scipy.ndimage import gaussian_filter

    squares = np.where(known, (apart**2).sum(axis=-1) / np.maximum(noise, TINY) ** 2, 0.0)
    usual = min(np.sqrt(np.percentile(squares[known], QUIET)) / QUIET_RAYLEIGH, MOST_NOISE)
    near = gaussian_filter(known.astype(np.float64), 1.0)
    squares = gaussian_filter(squares, 1.0) / np.maximum(near, ENOUGH)
    share = 1.0 / (1.0 + ((STANDS_OUT * usual) ** 2 / np.maximum(squares, TINY)) ** 3)
    return np.asarray(gaussian_filter(share, 1.0))


def continue_warp(warp: Warp, points: Floats) -> Floats:
    """(N, 2) targets of points, linearly continued beyond the warp's own extent."""
    size = np.array(warp.coefficients.shape[1::-1], dtype=np.float64)
    slack = 1e-6 * warp.spacing  # rounding must not carry a point over the border
    low = warp.origin + warp.spacing + slack
    high = warp.origin + warp.spacing * (size - 2.0) - slack
    nearest = np.clip(points, low, high)
    targets, gradient = warp_points(warp, nearest)
    return np.asarray(targets + np.einsum("nij,nj->ni", gradient, points - nearest))


def fill_gaps(values: Floats, known: Bools) -> Floats:
    """Fill what is not known of an (R, C, D) grid with local means of what is."""
    from scipy.ndimage import gaussian_filter

    filled = np.where(known[..., None], values, 0.0)
    missing = ~known
    reach, largest = 1.0, float(max(known.shape))
    while missing.any() and known.any():
        weight = gaussian_filter(known.astype(np.float64), reach, mode="constant")
        near = missing & ((weight > ENOUGH) | (reach > largest))
        for k in range(values.shape[-1]):
            total = gaussian_filter(np.where(known, values[..., k], 0.0), reach, mode="constant")
            filled[..., k][near] = total[near] / np.maximum(weight[near], 1e-12)
        missing &= ~near
        reach *= 2.0
    return filled


def _lattice(along: Ints, spacing: int) -> Floats:
    before = np.arange(-MARGIN, len(along) + MARGIN)
    return np.asarray(along[0] + spacing * before, dtype=np.float64)


def spline_through(targets: Floats) -> Floats:
    """Coefficients of the spline through an (R, C, 2) grid of targets."""
    from scipy.ndimage import spline_filter

    parts = [spline_filter(np.ascontiguousarray(targets[..., k]), order=3) for k in range(2)]
    return np.stack([np.asarray(part, dtype=np.float64) for part in parts], axis=-1)
