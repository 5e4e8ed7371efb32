"""Which grid points a local fit may use."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Ints


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """Square neighbourhoods of one size.

    Attributes
    ----------
    centres : (N,) int64
        Flat index of the grid point that each window belongs to.
    neighbours : (N, K) int64
        Flat indices of the K = (2 radius + 1)^2 points of each window, row by row; the
        centre's own index where `inside` is False.
    inside : (N, K) bool
        Which of them may be used.
    offsets : (K, 2) int64
        Offset (column, row) of each from the centre, in grid points.
    """

    centres: Ints
    neighbours: Ints
    inside: Bools
    offsets: Ints


def connected_windows(usable: Bools, *, window: int, chunk: int) -> Iterator[Windows]:
    """Gather for each usable point the usable points around it, never across a gap.

    A neighbour counts only if a path of edge-sharing usable points inside the window
    leads to it. Where a rim or a hole takes points away, the window grows, ring by ring
    and at most to twice its radius, until it holds as many points as a full one.

    Parameters
    ----------
    usable : (R, C)
        Points that may be used.
    window : int
        Points across a full window, odd.
    chunk : int
        Most windows to hand out at a time, to bound memory.

    Yields
    ------
    Windows
        Each usable point is a centre exactly once.
    """
    radius = window // 2
    waiting = np.flatnonzero(usable)
    for grown in range(radius, 2 * radius + 1):
        left_over = []
        for start in range(0, len(waiting), chunk):
            windows = _windows_around(usable, waiting[start : start + chunk], grown)
            enough = (windows.inside.sum(axis=1) >= window**2) | (grown == 2 * radius)
            left_over.append(windows.centres[~enough])
            if enough.any():
                yield _select(windows, enough)
        waiting = np.concatenate(left_over) if left_over else waiting[:0]


def _windows_around(usable: Bools, centres: Ints, radius: int) -> Windows:
    rows, cols = np.divmod(centres, usable.shape[1])
    span = np.arange(-radius, radius + 1)
    down, right = (part.ravel() for part in np.meshgrid(span, span, indexing="ij"))
    padded = np.pad(usable, radius)
    around = padded[rows[:, None] + down + radius, cols[:, None] + right + radius]
    inside, gaps = around, ~around.all(axis=1)
    inside[gaps] = _reachable(around[gaps].reshape(-1, len(span), len(span)), radius)
    neighbours = centres[:, None] + np.where(inside, down * usable.shape[1] + right, 0)
    return Windows(centres, neighbours, inside, np.stack([right, down], axis=1))


def _reachable(around: Bools, radius: int) -> Bools:
    """Points of each window that a path of usable points joins to its centre, (N, K)."""
    reached = np.zeros_like(around)
    reached[:, radius, radius] = True
    count = -1
    while (now := int(np.count_nonzero(reached))) != count:
        count = now
        spread = reached.copy()
        spread[:, 1:] |= reached[:, :-1]
        spread[:, :-1] |= reached[:, 1:]
        spread[:, :, 1:] |= reached[:, :, :-1]
        spread[:, :, :-1] |= reached[:, :, 1:]
        reached = spread & around
    return reached.reshape(len(around), -1)


def _select(windows: Windows, rows: Bools) -> Windows:
    return Windows(
        windows.centres[rows], windows.neighbours[rows], windows.inside[rows], windows.offsets
    )
