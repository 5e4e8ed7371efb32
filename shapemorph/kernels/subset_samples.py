"""The pixels of matched subsets: which of them count, and the deformed grey that was found there.

What is asked about the residual of a match reads its subsets from here, a block of points
at a time, so that a subset is interpolated once.
"""

from typing import TypeAlias

import numpy as np
from numba import njit
from numpy.typing import NDArray

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.kernels.inner import inner
from shapemorph.kernels.subset_box import pixels_inside, whole_box
from shapemorph.kernels.subset_rows import common_jump, path_at, paths
from shapemorph.kernels.subset_taps import grey_gathered, grey_in_step, scale_of
from shapemorph.kernels.vectors import LANES, load, spread, store

Counts: TypeAlias = NDArray[np.int32]

_ZERO = np.float32(0.0)
_ONE = np.float32(1.0)


@inner()
def _mark_seen(inside, other_inside, x, y, warp, radius, weights) -> None:  # type: ignore[no-untyped-def]
    """Give a pixel of a subset weight one if it counts in both pictures."""
    height, length = other_inside.shape
    for j in range(2 * radius + 1):
        b = float(j - radius)
        start_x, along_x = x + warp[0] + b * (warp[2] + warp[5] * b), warp[1] + warp[4] * b
        start_y, along_y = y + warp[6] + b * (warp[8] + warp[11] * b), warp[7] + warp[10] * b
        for i in range(2 * radius + 1):
            if inside[y + j - radius, x + i - radius] == _ZERO:
                continue
            a = float(i - radius)
            at_x, at_y = (
                start_x + a * (along_x + warp[3] * a),
                start_y + a * (along_y + warp[9] * a),
            )
            if 2.0 <= at_x < length - 4.0 and 2.0 <= at_y < height - 4.0:
                weights[j, i] = other_inside[int(at_y + 0.5), int(at_x + 0.5)]


@njit(cache=True, nogil=True, error_model="numpy")
def weigh_subsets(
    inside: Greys,
    counts: Counts,
    other_inside: Greys,
    other_counts: Counts,
    points: Ints,
    warps: Floats,
    radius: int,
    weights: Greys,
) -> None:
    """Mark the pixels of subsets that count in both pictures.

    Parameters
    ----------
    inside, counts, other_inside, other_counts, points, warps, radius
        As in :func:`~shapemorph.kernels.icgn.match_subsets`; the warps are its results.
    weights : (N, 2 radius + 1, L) float32
        Filled with 1 and 0 in its first 2 radius + 1 columns; the others stay.
    """
    width = 2 * radius + 1
    for k in range(points.shape[0]):
        x, y = points[k, 0], points[k, 1]
        seen = pixels_inside(counts, x - radius, y - radius, x + radius + 1, y + radius + 1)
        full = seen == width * width and whole_box(other_counts, x, y, warps[k], radius) == 2
        for j in range(width):
            for i in range(width):
                weights[k, j, i] = _ONE if full else _ZERO
        if not full and seen > 0:
            _mark_seen(inside, other_inside, x, y, warps[k], radius, weights[k])


@inner()
def _within(shape, x, y, warp, radius) -> bool:  # type: ignore[no-untyped-def]
    """Tell if all that vectors read around a subset whose pixels stay in step is inside."""
    height, length = shape
    left, top = x + warp[0] - radius, y + warp[6] - radius
    room = 2 * radius + LANES + 5
    return bool(4.0 <= left < length - room and 4.0 <= top < height - room + LANES)


@njit(cache=True, nogil=True, error_model="numpy")
def sample_subsets(
    coefficients: Greys,
    wide: int | None,
    points: Ints,
    warps: Floats,
    radius: int,
    weights: Greys,
    grey: Greys,
) -> None:
    """Interpolate the deformed picture at the pixels of subsets that count.

    Parameters
    ----------
    coefficients, wide, points, warps, radius
        As in :func:`~shapemorph.kernels.icgn.match_subsets`; the warps are its results.
    weights : (N, 2 radius + 1, L) float32
        See :func:`weigh_subsets`; L is a multiple of LANES, columns beyond the subset are 0.
    grey : (N, 2 radius + 1, L) float32
        Filled in whole blocks of columns as far as the subset reaches; 0 where a pixel does
        not count.
    """
    width, lanes = weights.shape[1], weights.shape[2]
    stride = coefficients.shape[1]
    lane_x = np.empty(lanes, dtype=np.float32)
    for i in range(lanes):
        lane_x[i] = np.float32(i - radius)
    scale = spread(scale_of(wide))
    for k in range(points.shape[0]):
        x, y, warp = points[k, 0], points[k, 1], warps[k]
        ux = warp[0], warp[1] - 1.0, warp[2], warp[3], warp[4], warp[5]
        uy = warp[6], warp[7], warp[8] - 1.0, warp[9], warp[10], warp[11]
        jump_x, alike_x = common_jump(ux, radius)
        jump_y, alike_y = common_jump(uy, radius)
        in_step = alike_x and alike_y and _within(coefficients.shape, x, y, warp, radius)
        corner = (y - radius + int(jump_y)) * stride + x - radius + int(jump_x)
        for first in range(0, width, LANES):
            xs = load(lane_x, first)
            ahead = xs - spread(float(first - radius))
            x_path, x_slope, x_bend = paths(ux, xs, 1)
            y_path, y_slope, y_bend = paths(uy, xs, 1)
            x_path, y_path = x_path - spread(jump_x), y_path - spread(jump_y)
            for j in range(width):
                b = spread(float(j - radius))
                t = path_at(x_path, x_slope, x_bend, b, 1)
                u = path_at(y_path, y_slope, y_bend, b, 1)
                at = (k * width + j) * lanes + first
                weight = load(weights, at)
                tap = corner + j * stride + first
                if in_step:
                    found = grey_in_step(coefficients, stride, tap, t, u, wide)
                else:
                    found = grey_gathered(coefficients, stride, tap, t + ahead, u, weight, wide)
                store(grey, at, found * scale * weight)
