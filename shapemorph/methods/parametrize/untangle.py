"""Turn back the few triangles that a conformal map of a rough mesh turns over."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.methods.distortion import singular_values
from shapemorph.methods.parametrize.harmonic_disk import spread_between

ROUNDS = 6


def untangle(vertices: Floats, faces: Ints, plane: Floats) -> Floats:
    """Spread the vertices around flipped triangles evenly again.

    Each round takes the flipped triangles with one more ring around them, keeps the
    outline of that patch and places the vertices within between their neighbours; it
    counts only if it leaves fewer flips.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
    plane : (V, 2)
        x right, y up.

    Returns
    -------
    (V, 2)
    """
    best, flipped = plane, flipped_faces(vertices, faces, plane)
    for rings in range(1, ROUNDS + 1):
        if not flipped.any():
            break
        tried = _spread_patch(vertices, faces, best, _grow(faces, flipped, rings))
        still = flipped_faces(vertices, faces, tried)
        if still.sum() < flipped.sum():
            best, flipped = tried, still
    return best


def flipped_faces(vertices: Floats, faces: Ints, plane: Floats) -> Bools:
    """Mark the triangles that lie upside down or have no area in the plane."""
    flipped: Bools = singular_values(vertices, faces, plane).sigma_2 <= 0
    return flipped


def _grow(faces: Ints, chosen: Bools, rings: int) -> Bools:
    touched = np.zeros(int(faces.max()) + 1, dtype=bool)
    grown = chosen
    for _ in range(rings):
        touched[faces[grown]] = True
        grown = touched[faces].any(axis=1)
    return grown


def _spread_patch(vertices: Floats, faces: Ints, plane: Floats, patch: Bools) -> Floats:
    """Place anew the vertices that only faces of the patch touch, off the mesh's border."""
    inside = np.zeros(len(vertices), dtype=bool)
    inside[faces[patch]] = True
    inside[faces[~patch]] = False
    inside[_border(faces)] = False
    used, renamed = np.unique(faces[patch], return_inverse=True)
    fixed = np.flatnonzero(~inside[used])
    moved = plane.copy()
    local = renamed.reshape(-1, 3).astype(np.int64)
    moved[used] = spread_between(vertices[used], local, fixed, plane[used][fixed])
    return moved


def _border(faces: Ints) -> Ints:
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    rows, count = np.unique(edges, axis=0, return_counts=True)
    border: Ints = np.unique(rows[count == 1])
    return border
