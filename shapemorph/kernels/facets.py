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
    vertices: Floats, faces: Ints, plane: Floats, height_sign: float
) -> tuple[Floats, Floats, Floats]:
    """Find the singular values of the map of each triangle from space to the plane.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
    plane : (V, 2)
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
        first_x = (plane[b, 0] - plane[a, 0]) / length
        first_y = height_sign * (plane[b, 1] - plane[a, 1]) / length
        second_x = (plane[c, 0] - plane[a, 0] - first_x * along) / height
        second_y = (height_sign * (plane[c, 1] - plane[a, 1]) - first_y * along) / height
        same = 0.5 * np.sqrt((first_x + second_y) ** 2 + (first_y - second_x) ** 2)
        turned = 0.5 * np.sqrt((first_x - second_y) ** 2 + (first_y + second_x) ** 2)
        sigma_1[f], sigma_2[f] = same + turned, same - turned
    return sigma_1, sigma_2, areas


@njit(cache=True, nogil=True)
def signed_area(plane: Floats, faces: Ints) -> float:
    """Sum of the areas of triangles in the plane, counter-clockwise ones positive.

    Parameters
    ----------
    plane : (P, 2)
    faces : (F, 3)
    """
    total = 0.0
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, vx = plane[b, 0] - plane[a, 0], plane[c, 0] - plane[a, 0]
        uy, vy = plane[b, 1] - plane[a, 1], plane[c, 1] - plane[a, 1]
        total += ux * vy - uy * vx
    return 0.5 * total


@njit(cache=True, nogil=True)
def plane_moments(space: Floats, plane: Floats, faces: Ints) -> tuple[Floats, Floats, Floats]:
    """Integrate over flat triangles, each by its area whatever its sense.

    Parameters
    ----------
    space : (P, 3)
    plane : (P, 2)
    faces : (F, 3)

    Returns
    -------
    centre : (2,)
        Centre of area in the plane.
    second : (2, 2)
        Mean of x x^T about the centre.
    along : (2, 3)
        Mean of x (X - M)^T over the centroids of the triangles, where X is their position in
        space and M its mean.
    """
    total, centre, mean = 0.0, np.zeros(2), np.zeros(3)
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, vx = plane[b, 0] - plane[a, 0], plane[c, 0] - plane[a, 0]
        uy, vy = plane[b, 1] - plane[a, 1], plane[c, 1] - plane[a, 1]
        area = abs(ux * vy - uy * vx)
        total += area
        for i in range(2):
            centre[i] += area * (plane[a, i] + plane[b, i] + plane[c, i]) / 3.0
        for i in range(3):
            mean[i] += (space[a, i] + space[b, i] + space[c, i]) / 3.0
    centre /= total
    mean /= len(faces)
    second, along = np.zeros((2, 2)), np.zeros((2, 3))
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, uy = plane[a, 0] - centre[0], plane[a, 1] - centre[1]
        vx, vy = plane[b, 0] - centre[0], plane[b, 1] - centre[1]
        wx, wy = plane[c, 0] - centre[0], plane[c, 1] - centre[1]
        share = abs((vx - ux) * (wy - uy) - (vy - uy) * (wx - ux)) / total
        x, y = (ux + vx + wx) / 3.0, (uy + vy + wy) / 3.0
        second[0, 0] += share * (ux * ux + vx * vx + wx * wx + 9.0 * x * x) / 12.0
        second[0, 1] += share * (ux * uy + vx * vy + wx * wy + 9.0 * x * y) / 12.0
        second[1, 1] += share * (uy * uy + vy * vy + wy * wy + 9.0 * y * y) / 12.0
        for i in range(3):
            middle = (space[a, i] + space[b, i] + space[c, i]) / 3.0 - mean[i]
            along[0, i] += share * x * middle
            along[1, i] += share * y * middle
    second[1, 0] = second[0, 1]
    return centre, second, along


@njit(cache=True, nogil=True)
def affine_maps(source: Floats, faces: Ints, target: Floats) -> Floats:
    """Find the matrix of the affine map of each triangle between two planes.

    Parameters
    ----------
    source : (P, 2)
    faces : (F, 3)
    target : (F, 3, 2)
        Where the corners go.

    Returns
    -------
    (F, 2, 2)
        d target / d source, zero for triangles without area.
    """
    maps = np.zeros((len(faces), 2, 2))
    for f in range(len(faces)):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        ux, vx = source[b, 0] - source[a, 0], source[c, 0] - source[a, 0]
        uy, vy = source[b, 1] - source[a, 1], source[c, 1] - source[a, 1]
        twice = ux * vy - uy * vx
        if twice == 0.0:
            continue
        for i in range(2):
            to_u = target[f, 1, i] - target[f, 0, i]
            to_v = target[f, 2, i] - target[f, 0, i]
            along_x, along_y = (to_u * vy - to_v * uy) / twice, (to_v * ux - to_u * vx) / twice
            if np.isfinite(along_x) and np.isfinite(along_y):
                maps[f, i, 0], maps[f, i, 1] = along_x, along_y
    return maps
