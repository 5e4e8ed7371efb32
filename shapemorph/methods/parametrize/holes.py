"""Fill the holes of a surface so that a flattening does not tear around them."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints


def loop_length(vertices: Floats, loop: Ints) -> float:
    """Length of a closed loop of vertices, in the unit of the vertices."""
    return float(np.linalg.norm(vertices[np.roll(loop, -1)] - vertices[loop], axis=1).sum())


def order_by_length(vertices: Floats, loops: list[Ints]) -> list[Ints]:
    """Sort boundary loops, the longest first: it is the rim, the others are holes."""
    return sorted(loops, key=lambda loop: -loop_length(vertices, loop))


def fan_fill(vertices: Floats, faces: Ints, holes: list[Ints]) -> tuple[Floats, Ints]:
    """Close each hole by a fan around the mean of its vertices.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
    holes : list of (K,)
        Loops in the direction of the faces along them.

    Returns
    -------
    vertices : (V + holes, 3)
        The given ones first.
    faces : (F + K's, 3)
        The given ones first.
    """
    if not holes:
        return vertices, faces
    centres = np.array([vertices[hole].mean(axis=0) for hole in holes])
    fans = [
        np.stack([np.roll(hole, -1), hole, np.full(len(hole), len(vertices) + k)], axis=1)
        for k, hole in enumerate(holes)
    ]
    return np.concatenate([vertices, centres]), np.concatenate([faces, *fans])
