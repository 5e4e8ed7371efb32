"""A grid of quads with fewer of them: whole blocks become one, rims and holes stay."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints

MOST_HALVINGS = 6
"""The largest block has 2 to this power quads a side."""
ROUND_OFF = 1e-6


def thinned_quads(cells: Ints, positions: Floats, *, most: int) -> Ints:
    """Replace square blocks of a grid's quads by one each until few are left.

    Blocks get larger until it is so. One of which a quad is missing keeps the others, or has
    smaller blocks in it, so that the outline does not change.

    Parameters
    ----------
    cells : (M, 4)
        Quads of neighbours on a regular grid, as row numbers of `positions`.
    positions : (N, 2)
        Of the grid points, px; no two points of cells at one place.
    most : int
        Number of quads that is aimed at; rims and holes keep theirs.

    Returns
    -------
    (K, 4)
        Row numbers, in the orientation of `cells`; the same where there are few enough.
    """
    if len(cells) <= most:
        return cells
    place = _places(cells, positions)
    thinned = cells
    for largest in (2**k for k in range(1, MOST_HALVINGS + 1)):
        if len(thinned) <= most:
            break
        thinned = _with_blocks(cells, place, largest)
    return thinned


def _places(cells: Ints, positions: Floats) -> Ints:
    """Column and row (N, 2) of each point in its grid."""
    spacing = np.ptp(positions[cells, 0], axis=1).min()
    place: Ints = np.floor(positions / spacing + ROUND_OFF).astype(np.int64)
    return place


def _with_blocks(cells: Ints, place: Ints, largest: int) -> Ints:
    """Join blocks of that many quads a side where they are whole, else of half as many."""
    found, side = [], largest
    while side > 1 and len(cells):
        joined, cells = _join_blocks(cells, place, side)
        found.append(joined)
        side //= 2
    return np.concatenate([*found, cells])


def _join_blocks(cells: Ints, place: Ints, side: int) -> tuple[Ints, Ints]:
    """Quads of whole blocks, and the quads of all other blocks as they are."""
    corners = place[cells]
    first = corners.min(axis=1)
    block = first // side
    key = block[:, 1] * (int(block[:, 0].max()) + 1) + block[:, 0]
    _, index, count = np.unique(key, return_inverse=True, return_counts=True)
    is_whole = count == side * side
    whole = is_whole[index]
    # Corner k of a block is corner k of the quad that lies at that corner of it.
    inside = first - block * side
    offset = corners - first[:, None, :]
    at_corner = (inside[:, None, :] == offset * (side - 1)).all(axis=2) & whole[:, None]
    joined = np.empty((int(is_whole.sum()), 4), dtype=np.int64)
    number = np.cumsum(is_whole) - 1
    for k in range(4):
        chosen = at_corner[:, k]
        joined[number[index[chosen]], k] = cells[chosen, k]
    return joined, cells[~whole]
