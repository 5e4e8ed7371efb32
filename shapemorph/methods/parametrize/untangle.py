"""Turn back the few triangles that a conformal map of a rough mesh turns over."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.kernels.components import connect
from shapemorph.methods.distortion import singular_values
from shapemorph.methods.parametrize.disk import boundary_loops
from shapemorph.methods.parametrize.harmonic_disk import spread_between
from shapemorph.methods.parametrize.holes import fill_holes, order_by_length, place_hubs

MOST_RINGS = 12


def untangle(vertices: Floats, faces: Ints, plane: Floats) -> Floats:
    """Spread the vertices around flipped triangles evenly again.

    Each round takes the flipped triangles with one more ring around them, keeps the
    outline of every patch that they form and places the vertices within between their
    neighbours. A patch keeps its new places if fewer of its triangles are flipped. The
    rim stays, the edges of holes may move.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
        A disk with holes.
    plane : (V, 2)
        x right, y up.

    Returns
    -------
    (V, 2)
    """
    loops = order_by_length(vertices, boundary_loops(faces, name="the surface"))
    closed, closed_faces = fill_holes(vertices, faces, loops[1:])
    placed = place_hubs(plane, closed_faces, len(closed))
    for rings in range(1, MOST_RINGS + 1):
        flipped = flipped_faces(closed, closed_faces, placed)
        flipped[len(faces) :] = False
        if not flipped.any():
            break
        patch = _grow(closed_faces, flipped, rings)
        placed = _spread_patches(closed, closed_faces, placed, patch, loops[0])
    return placed[: len(vertices)]


def flipped_faces(vertices: Floats, faces: Ints, plane: Floats) -> Bools:
    """Mark the triangles that lie upside down or have no area in the plane."""
    return np.asarray(singular_values(vertices, faces, plane).sigma_2 <= 0)


def _grow(faces: Ints, chosen: Bools, rings: int) -> Bools:
    touched = np.zeros(int(faces.max()) + 1, dtype=bool)
    grown = chosen
    for _ in range(rings):
        touched[faces[grown]] = True
        grown = np.asarray(touched[faces].any(axis=1))
    return grown


def _spread_patches(
    vertices: Floats, faces: Ints, plane: Floats, patch: Bools, rim: Ints
) -> Floats:
    """Place anew the vertices that only faces of the patches touch, where that helps."""
    used, renamed = np.unique(faces[patch], return_inverse=True)
    local = renamed.reshape(-1, 3).astype(np.int64)
    free = np.ones(len(vertices), dtype=bool)
    free[faces[~patch]] = False
    free[rim] = False
    fixed = np.flatnonzero(~free[used])
    before = plane[used]
    after = spread_between(vertices[used], local, fixed, before[fixed])
    label = _patch_labels(local, len(used))
    count = int(label.max()) + 1
    space = vertices[used]
    flips = [
        np.bincount(label[local[flipped_faces(space, local, each), 0]], minlength=count)
        for each in (before, after)
    ]
    better = (flips[1] < flips[0])[label]
    placed = plane.copy()
    placed[used[better]] = after[better]
    return placed


def _patch_labels(faces: Ints, count: int) -> Ints:
    """Give every vertex the number of the connected patch that it belongs to."""
    label: Ints = connect(faces.ravel(), np.roll(faces, -1, axis=1).ravel(), count)[1]
    return label
