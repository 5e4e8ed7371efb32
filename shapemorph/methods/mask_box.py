"""The smallest picture that shows a mask through a linear map."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats

ROOM = 6  # px around the mask
TIGHTER = 0.75  # share of its pixels that a picture must save by being turned


def tight_map(linear: Floats, mask: Bools) -> tuple[Floats, tuple[int, int]]:
    """Place a linear map of a picture so that what it shows fits into a small picture.

    The map is followed by a rotation where that makes the picture much smaller.

    Parameters
    ----------
    linear : (2, 2)
    mask : (H, W)
        What must be shown; not empty.

    Returns
    -------
    matrix : (2, 3)
        Position in the new picture = matrix[:, :2] @ position + matrix[:, 2].
    shape : (H', W')
        Of the new picture, px, with some room around the mask.
    """
    hull, matrix = _hull(mask), linear
    for _ in range(2):
        corners = hull @ matrix.T
        low, extent = corners.min(axis=0), np.ptp(corners, axis=0)
        turn = _upright(corners)
        if np.prod(np.ptp(corners @ turn.T, axis=0) + ROOM) > TIGHTER * np.prod(extent + ROOM):
            break
        matrix = turn @ matrix
    width, height = (int(v) for v in np.ceil(extent) + 1 + 2 * ROOM)
    return np.column_stack([matrix, ROOM - low]), (height, width)


def _hull(mask: Bools) -> Floats:
    """(N, 2) corners of the convex hull of a mask that is not empty, px."""
    import cv2

    rows = np.flatnonzero(mask.any(axis=1))
    first = mask[rows].argmax(axis=1)
    last = mask.shape[1] - 1 - mask[rows, ::-1].argmax(axis=1)
    ends = np.concatenate([np.column_stack([first, rows]), np.column_stack([last, rows])])
    hull: Floats = cv2.convexHull(ends.astype(np.float32))[:, 0].astype(np.float64)
    return hull


def _upright(corners: Floats) -> Floats:
    """(2, 2) rotation that lays the smallest rectangle about a convex region upright."""
    edges = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(edges, axis=1)
    units = edges[lengths > 0] / lengths[lengths > 0, None]
    if len(units) == 0:
        return np.eye(2)
    turns = np.stack([units, np.column_stack([-units[:, 1], units[:, 0]])], axis=1)
    areas = np.prod(np.ptp(np.einsum("kij,nj->kni", turns, corners), axis=1), axis=1)
    turn: Floats = turns[np.argmin(areas)]
    return turn
