"""Sizes of triangles in space, and how a map to the plane stretches them."""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats, Ints


@njit(cache=True, nogil=True)
def measure_triangles(vertices: Floats, faces: Ints) -> tuple[Floats, Floats]:
    """Measure triangles.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)

    Returns
    -------
    areas : (F,)
    longest : (F,)
        Longest side.
    """
    areas = np.empty(len(faces))
    longest = np.empty(len(faces))
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, vx = vertices[b, 0] - vertices[a, 0], vertices[c, 0] - vertices[a, 0]
        uy, vy = vertices[b, 1] - vertices[a, 1], vertices[c, 1] - vertices[a, 1]
        uz, vz = vertices[b, 2] - vertices[a, 2], vertices[c, 2] - vertices[a, 2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        areas[f] = 0.5 * np.sqrt(x * x + y * y + z * z)
        wx, wy, wz = vx - ux, vy - uy, vz - uz
        first = ux * ux + uy * uy + uz * uz
        second = vx * vx + vy * vy + vz * vz
        third = wx * wx + wy * wy + wz * wz
        longest[f] = np.sqrt(max(first, second, third))
    return areas, longest


@njit(cache=True, nogil=True)
def stretch_triangles(
    vertices: Floats, faces: Ints, plane: Floats, flat_faces: Ints, height_sign: float
) -> tuple[Floats, Floats, Floats]:
    """Find the singular values of the map of each triangle from space to the plane.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
    plane : (P, 2)
    flat_faces : (F, 3)
        The same triangles in rows of `plane`.
    height_sign : float
        -1 where the second coordinate of the plane runs downwards, +1 where upwards.

    Returns
    -------
    sigma_1, sigma_2 : (F,)
        The second is negative where the triangle lies upside down; NaN without area.
    areas : (F,)
        In space.
    """
    count = len(faces)
    sigma_1 = np.full(count, np.nan)
    sigma_2 = np.full(count, np.nan)
    areas = np.zeros(count)
    for f in range(count):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, vx = vertices[b, 0] - vertices[a, 0], vertices[c, 0] - vertices[a, 0]
        uy, vy = vertices[b, 1] - vertices[a, 1], vertices[c, 1] - vertices[a, 1]
        uz, vz = vertices[b, 2] - vertices[a, 2], vertices[c, 2] - vertices[a, 2]
        x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = np.sqrt(ux * ux + uy * uy + uz * uz)
        twice = np.sqrt(x * x + y * y + z * z)
        if not twice > 0.0:
            continue
        areas[f] = 0.5 * twice
        along, height = (ux * vx + uy * vy + uz * vz) / length, twice / length
        a, b, c = flat_faces[f, 0], flat_faces[f, 1], flat_faces[f, 2]
        first_x = (plane[b, 0] - plane[a, 0]) / length
        first_y = height_sign * (plane[b, 1] - plane[a, 1]) / length
        second_x = (plane[c, 0] - plane[a, 0] - first_x * along) / height
        second_y = (height_sign * (plane[c, 1] - plane[a, 1]) - first_y * along) / height
        same = 0.5 * np.hypot(first_x + second_y, first_y - second_x)
        turned = 0.5 * np.hypot(first_x - second_y, first_y + second_x)
        sigma_1[f], sigma_2[f] = same + turned, same - turned
    return sigma_1, sigma_2, areas
