"""Motion in the middle of a matched subset that its shape function has not followed.

What is left of the grey after a match, near the centre, is looked at as a small shift of
its own: where the field bends more sharply than the shape function can, the centre lies
elsewhere than the whole subset says.
"""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.kernels.inner import inner
from shapemorph.kernels.small_linear import clear
from shapemorph.kernels.subset_light import fit_light, residual
from shapemorph.kernels.subset_rows import VECTOR_FLAGS
from shapemorph.kernels.vectors import LANES, fused, load, spread, total


@inner(fastmath=VECTOR_FLAGS)
def _sum_up(  # type: ignore[no-untyped-def]
    reference, x, y, weights, grey, k, half, lane_x, box, bell, solution, sums
) -> None:  # fmt: skip
    """Fill the sums xx, xy, yy, xr, yr with bell weights, xx, xy, yy with their squares, rr, ss."""
    width, lanes = weights.shape[1], weights.shape[2]
    radius = (width - 1) // 2
    stride = reference.shape[2]
    plane = reference.shape[1] * stride
    clear(sums)
    for first in range(0, width, LANES):
        xs, kept, across = load(lane_x, first), load(box, first), load(bell, first)
        xx = xy = yy = rx = ry = qxx = qxy = qyy = left = steep = spread(0.0)
        for j in range(radius - half, radius + half + 1):
            at = (k * width + j) * lanes + first
            from_ = (y - radius + j) * stride + x - radius + first
            weight = load(weights, at) * kept
            rest = residual(
                load(reference, from_), load(grey, at), xs, spread(float(j - radius)), solution,
                weight,
            )  # fmt: skip
            slope_x = load(reference, from_ + plane) * weight
            slope_y = load(reference, from_ + 2 * plane) * weight
            left = fused(rest, rest, left)
            steep = fused(slope_x, slope_x, fused(slope_y, slope_y, steep))
            down = spread(bell[j])
            by_x, by_y = slope_x * down, slope_y * down
            xx, xy, yy = (
                fused(by_x, slope_x, xx),
                fused(by_x, slope_y, xy),
                fused(by_y, slope_y, yy),
            )
            rx, ry = fused(by_x, rest, rx), fused(by_y, rest, ry)
            qxx, qxy, qyy = fused(by_x, by_x, qxx), fused(by_x, by_y, qxy), fused(by_y, by_y, qyy)
        twice = across * across
        sums[0] += total(xx * across)
        sums[1] += total(xy * across)
        sums[2] += total(yy * across)
        sums[3] += total(rx * across)
        sums[4] += total(ry * across)
        sums[5] += total(qxx * twice)
        sums[6] += total(qxy * twice)
        sums[7] += total(qyy * twice)
        sums[8] += total(left)
        sums[9] += total(steep)


@njit(cache=True, nogil=True, error_model="numpy")
def rest_motion(
    reference: Greys,
    points: Ints,
    weights: Greys,
    grey: Greys,
    half: int,
    spread_px: float,
    shift: Floats,
    doubt: Floats,
    misfit: Floats,
) -> None:
    """Fit a shift to what a match has left near the centre of each subset.

    Parameters
    ----------
    reference, points
        As in :func:`~shapemorph.kernels.icgn.match_subsets`.
    weights, grey : (N, R, L) float32
        See :func:`~shapemorph.kernels.subset_samples.sample_subsets`.
    half : int
        Half width of the part that is looked at, px; not more than the radius of the subset.
    spread_px : float
        Standard deviation of its Gaussian weights, px.
    shift : (N, 2)
        Filled with the motion of the reference pattern that is left, px of the reference;
        NaN where there is too little pattern.
    doubt : (N, 3)
        Filled with its variance along x, along y and its covariance, for noise of one.
    misfit : (N, 2)
        Filled with the mean square of what is left, and of the slopes along both axes.
    """
    lanes = weights.shape[2]
    radius = (weights.shape[1] - 1) // 2
    rows = np.empty((3, lanes), dtype=np.float32)
    lane_x, box, bell = rows[0], rows[1], rows[2]
    for i in range(lanes):
        lane_x[i] = np.float32(i - radius)
        box[i] = np.float32(1.0 if abs(i - radius) <= half else 0.0)
        bell[i] = np.float32(np.exp(-0.5 * ((i - radius) / spread_px) ** 2))
    system, sums = np.zeros((10, 4)), np.zeros(10)
    for k in range(points.shape[0]):
        shift[k, 0], shift[k, 1] = np.nan, np.nan
        misfit[k, 0], misfit[k, 1] = np.nan, np.nan
        x, y = points[k, 0], points[k, 1]
        count = fit_light(reference, x, y, weights, grey, k, half, lane_x, box, system)
        if count < 0.5 * (2 * half + 1) ** 2:
            continue
        _sum_up(reference, x, y, weights, grey, k, half, lane_x, box, bell, system[9], sums)
        xx, xy, yy = sums[0], sums[1], sums[2]
        misfit[k, 0], misfit[k, 1] = sums[8] / count, 0.5 * sums[9] / count
        det = xx * yy - xy * xy
        if not det > 0.02 * xx * yy:
            continue
        a, b, c = yy / det, -xy / det, xx / det
        qxx, qxy, qyy = sums[5], sums[6], sums[7]
        shift[k, 0], shift[k, 1] = a * sums[3] + b * sums[4], b * sums[3] + c * sums[4]
        doubt[k, 0] = a * a * qxx + 2.0 * a * b * qxy + b * b * qyy
        doubt[k, 1] = b * b * qxx + 2.0 * b * c * qxy + c * c * qyy
        doubt[k, 2] = a * b * qxx + (a * c + b * b) * qxy + b * c * qyy
