"""Loops of triangulation: points of a wanted density, edges flipped until triangles are round."""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Bools, Floats, Ints


@njit(cache=True)
def dither(density: Floats, threshold: Floats) -> Bools:
    """Choose cells so that their number per area follows a density (error diffusion).

    Parameters
    ----------
    density : (H, W)
        Wanted points per cell, 0 to 1.
    threshold : (H, W)
        About 0.5; noise in it breaks up regular patterns.

    Returns
    -------
    (H, W) bool
        Evenly spread cells; rows run left and right in turn.
    """
    height, width = density.shape
    chosen = np.zeros((height, width), dtype=np.bool_)
    debt = np.zeros((2, width + 2))
    for row in range(height):
        this, below = row % 2, (row + 1) % 2
        debt[below, :] = 0.0
        step = 1 if row % 2 == 0 else -1
        for k in range(width):
            col = k if step == 1 else width - 1 - k
            wanted = density[row, col] + debt[this, col + 1]
            chosen[row, col] = wanted > threshold[row, col]
            error = wanted - (1.0 if chosen[row, col] else 0.0)
            if density[row, col] == 0.0:
                error = 0.0
            debt[this, col + 1 + step] += error * 0.4375
            debt[below, col + 1 - step] += error * 0.1875
            debt[below, col + 1] += error * 0.3125
            debt[below, col + 1 + step] += error * 0.0625
    return chosen


@njit(cache=True)
def _cotangent(apex: Floats, first: Floats, second: Floats) -> float:
    """Cotangent of the angle at `apex` between two points of space."""
    ax, ay, az = first[0] - apex[0], first[1] - apex[1], first[2] - apex[2]
    bx, by, bz = second[0] - apex[0], second[1] - apex[1], second[2] - apex[2]
    cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    area = max(np.sqrt(cx * cx + cy * cy + cz * cz), 1e-300)
    return float((ax * bx + ay * by + az * bz) / area)


@njit(cache=True)
def _turn(a: Floats, b: Floats, c: Floats) -> float:
    """Twice the signed area of a triangle in the plane."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


@njit(cache=True)
def _replace(row: Ints, old: int, new: int) -> None:
    """Write `new` where a row of three says `old`."""
    for k in range(3):
        if row[k] == old:
            row[k] = new


@njit(cache=True)
def flip_edges(
    points: Floats, plane: Floats, triangles: Ints, neighbours: Ints, locked: Bools, passes: int
) -> tuple[Ints, int]:
    """Flip edges of a plane triangulation until it is Delaunay in space, or passes end.

    Parameters
    ----------
    points : (V, 3)
        Positions that decide which triangles are round.
    plane : (V, 2)
        Positions in the plane, where no triangle may turn over.
    triangles : (F, 3)
        Counter-clockwise in the plane.
    neighbours : (F, 3)
        Triangle opposite to each corner, -1 at the border.
    locked : (V,) bool
        An edge between two locked vertices is kept.
    passes : int

    Returns
    -------
    triangles : (F, 3)
    flips : int
        Of the last pass; 0 when settled.
    """
    faces, beside = triangles.copy(), neighbours.copy()
    flips = 0
    for _ in range(passes):
        flips = 0
        for t in range(faces.shape[0]):
            for k in range(3):
                n = beside[t, k]
                if n <= t:
                    continue
                a, b, c = faces[t, k], faces[t, (k + 1) % 3], faces[t, (k + 2) % 3]
                if locked[b] and locked[c]:
                    continue
                j = 0
                while beside[n, j] != t:
                    j += 1
                d = faces[n, j]
                opposite = _cotangent(points[a], points[b], points[c]) + _cotangent(
                    points[d], points[c], points[b]
                )
                if opposite > -1e-9:
                    continue
                if _turn(plane[a], plane[b], plane[d]) <= 0.0:
                    continue
                if _turn(plane[a], plane[d], plane[c]) <= 0.0:
                    continue
                # In n the corners run d, c, b: what lies across d-b and across d-c.
                across_bd, across_dc = beside[n, (j + 1) % 3], beside[n, (j + 2) % 3]
                across_ab, across_ac = beside[t, (k + 2) % 3], beside[t, (k + 1) % 3]
                faces[t, 0], faces[t, 1], faces[t, 2] = a, b, d
                beside[t, 0], beside[t, 1], beside[t, 2] = across_bd, n, across_ab
                faces[n, 0], faces[n, 1], faces[n, 2] = a, d, c
                beside[n, 0], beside[n, 1], beside[n, 2] = across_dc, across_ac, t
                if across_bd >= 0:
                    _replace(beside[across_bd], n, t)
                if across_ac >= 0:
                    _replace(beside[across_ac], t, n)
                flips += 1
                break
        if flips == 0:
            break
    return faces, flips
