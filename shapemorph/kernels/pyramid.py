"""Pictures at several reductions, each as the coefficients of a cubic B-spline."""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats, Greys
from shapemorph.kernels.inner import inner

NEGLIGIBLE = 1e-8  # share of a sample below which it has no say: the precision of float32
LANES = 16


@njit(cache=True, inline="always")
def index_inside(index: int, count: int, repeats: int) -> int:
    """Index within the line: repeated, or mirrored about its ends."""
    if 0 <= index < count:
        return index
    if repeats:
        return index % count
    if count == 1:
        return 0
    index = abs(index) % (2 * count - 2)
    return index if index < count else 2 * count - 2 - index


@inner()
def _filter_lanes(lines: Greys, root: float, reach: int, repeats: int) -> None:
    """Filter lines there and back with one pole in place, along the first axis."""
    count, lanes = lines.shape
    pole = np.float32(root)
    ending = np.float32(root / (root * root - 1.0))
    for lane in range(lanes):
        first = np.float32(0.0)
        for k in range(reach, -1, -1):
            first = pole * first + lines[index_inside(-k, count, repeats), lane]
        lines[0, lane] = first
    for i in range(1, count):
        for lane in range(lanes):
            lines[i, lane] += pole * lines[i - 1, lane]
    for lane in range(lanes):
        last = np.float32(0.0)
        if repeats:
            for k in range(reach, -1, -1):
                last = pole * (last - lines[(count - 1 + k) % count, lane])
        else:
            last = ending * (lines[count - 1, lane] + pole * lines[count - 2, lane])
        lines[count - 1, lane] = last
    for i in range(count - 2, -1, -1):
        for lane in range(lanes):
            lines[i, lane] = pole * (lines[i + 1, lane] - lines[i, lane])


@inner()
def _filter_block(
    texels: Greys,
    start: int,
    count: int,
    lanes: int,
    step: int,
    lane_step: int,
    poles: Floats,
    repeats: int,
) -> None:
    """Filter some lines, copied to where they fit the cache."""
    lines = np.empty((count, lanes), np.float32)
    gain = 1.0
    for k in range(len(poles)):
        gain *= (1.0 - poles[k]) * (1.0 - 1.0 / poles[k])
    for i in range(count):
        for lane in range(lanes):
            lines[i, lane] = np.float32(gain) * texels[start + i * step + lane * lane_step]
    for k in range(len(poles)):
        reach = int(np.ceil(np.log(NEGLIGIBLE) / np.log(abs(poles[k]))))
        _filter_lanes(lines, poles[k], reach, repeats)
    for i in range(count):
        for lane in range(lanes):
            texels[start + i * step + lane * lane_step] = lines[i, lane]


@njit(cache=True, nogil=True)
def filter_lines(
    texels: Greys,
    height: int,
    width: int,
    poles: Floats,
    down: int,
    repeats: int,
    first: int,
    last: int,
) -> None:
    """Turn some columns, or rows, of a picture into B-spline coefficients, in place.

    Parameters
    ----------
    texels : (height * width,)
        The picture, row by row.
    height, width : int
    poles : (P,)
        Of the filter, each within the unit circle: one for a cubic spline, two for a quintic.
    down : int
        1 for columns, 0 for rows; one after the other makes the picture's coefficients.
    repeats : int
        Beyond its border the picture goes on mirrored, or where this is 1 again from the
        other side.
    first, last : int
        Number of the first line, and of the one after the last.
    """
    count, step, lane_step = (height, width, 1) if down else (width, 1, width)
    for start in range(first, last, LANES):
        lanes = min(LANES, last - start)
        _filter_block(texels, start * lane_step, count, lanes, step, lane_step, poles, repeats)


def reduce_by_two(picture: Greys) -> Greys:
    """Average boxes of 2 x 2 texels; an odd last row or column stands for its pair."""
    height, width = picture.shape
    even = picture
    if height % 2 or width % 2:
        even = np.pad(picture, ((0, height % 2), (0, width % 2)), mode="edge")
    total = even[::2, ::2] + even[::2, 1::2]
    total += even[1::2, ::2]
    total += even[1::2, 1::2]
    total *= np.float32(0.25)
    return total
