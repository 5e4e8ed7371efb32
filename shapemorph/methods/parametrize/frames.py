"""Directions and sides that the projections share."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.methods.distortion import local_scale, singular_values, weighted_quantile


def screen(towards: Floats) -> tuple[Floats, Floats]:
    """Right and up of a viewer, up being Y as far as possible (X for a viewer along Y).

    Parameters
    ----------
    towards : (3,)
        Unit vector from the surface to the viewer.
    """
    upward = np.array([0.0, 1.0, 0.0]) if abs(towards[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    up = upward - (upward @ towards) * towards
    up /= np.linalg.norm(up)
    return np.cross(up, towards), up


def unit(direction: Floats) -> Floats:
    """Scale a vector to length one."""
    scaled: Floats = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    return scaled


def directed_areas(vertices: Floats, faces: Ints) -> Floats:
    """Give normals (F, 3) on the outer side, as long as the area of each face."""
    corners = vertices[faces]
    normals: Floats = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals


def vertex_areas(vertices: Floats, faces: Ints) -> Floats:
    """Give a third of the area of its faces for every vertex (V,)."""
    area = np.linalg.norm(directed_areas(vertices, faces), axis=1)
    shared = np.bincount(faces.ravel(), np.repeat(area / 3, 3), minlength=len(vertices))
    return np.asarray(shared, dtype=np.float64)


def show_outer_side(vertices: Floats, faces: Ints, plane: Floats) -> Floats:
    """Mirror a plane left to right if most of the surface lies in it upside down.

    A projection from inside (a bowl seen from within) needs it; what counts is the area
    on the surface, so that a few huge triangles at a pole do not decide.
    """
    corners = plane[faces]
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    side = np.sign(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    area = np.linalg.norm(directed_areas(vertices, faces), axis=1)
    return plane * np.array([-1.0, 1.0]) if side @ area < 0 else plane


def unit_median_scale(vertices: Floats, faces: Ints, plane: Floats) -> Floats:
    """Scale a plane so that half of the surface's area is magnified, half reduced."""
    distortion = singular_values(vertices, faces, plane)
    return plane / weighted_quantile(local_scale(distortion), distortion.area, 0.5)
