"""Lay a flattening out as a picture: scale, orientation, margin.

The picture shows the outer side of the surface, as a camera would: faces that run
counter-clockwise seen from outside run counter-clockwise on the screen, so their signed
area in (x right, y down) coordinates is negative.
"""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.core.image import Chart
from shapemorph.methods.distortion import local_scale, singular_values, weighted_quantile
from shapemorph.methods.parametrize.disk import Piece

MARGIN = 4  # px around the surface


def to_unit_scale(vertices: Floats, piece: Piece, plane: Floats) -> Floats:
    """Scale a flattening so that half of the area is magnified, half reduced.

    Parameters
    ----------
    vertices : (V, 3)
        Of the mesh, mm.
    piece : Piece
    plane : (N, 2)
        Any unit.

    Returns
    -------
    (N, 2)
        mm: the median local scale by area is 1.

    Raises
    ------
    StageError
        If no triangle lies the right way up.
    """
    distortion = singular_values(vertices[piece.vertex_ids], piece.faces, plane)
    median = weighted_quantile(local_scale(distortion), distortion.area, 0.5)
    if not median > 0:
        raise StageError(
            "flatten: no face lies the right way up: for flatten.method=orthographic turn "
            "flatten.axis round, else check the orientation of the faces"
        )
    return plane / median


def to_principal_axes(vertices: Floats, piece: Piece, plane: Floats) -> Floats:
    """Turn a flattening so that its longer axis lies along x.

    Of the two ways round, the one is taken in which the space axis that runs most along
    the picture's height points up.

    Parameters
    ----------
    vertices : (V, 3)
    piece : Piece
    plane : (N, 2)
        x right, y up.
    """
    corners = plane[piece.faces]
    space = vertices[piece.vertex_ids][piece.faces].mean(axis=1)
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    weight = (area / area.sum())[:, None]
    centres = corners.mean(axis=1)
    centre = (weight * centres).sum(axis=0)
    offsets = centres - centre
    _, axes = np.linalg.eigh(_second_moment(corners - centre, weight))
    along = axes[:, 1]
    turned = np.stack([along, [-along[1], along[0]]], axis=1)
    along_height = ((weight * (offsets @ turned)[:, 1:]).T @ (space - space.mean(axis=0))).ravel()
    if along_height[np.abs(along_height).argmax()] < 0:
        turned = -turned
    placed: Floats = (plane - centre) @ turned
    return placed


def _second_moment(corners: Floats, weight: Floats) -> Floats:
    """Mean of x x^T over triangles (M, 3, 2) with weights (M, 1) that sum to one."""
    middle = corners.mean(axis=1)
    at_corners = np.einsum("m,mki,mkj->ij", weight[:, 0], corners, corners)
    moment: Floats = (at_corners + 9.0 * (weight * middle).T @ middle) / 12.0
    return moment


def chart_at_scale(piece: Piece, plane: Floats, *, px_per_mm: float) -> Chart:
    """Turn a flattening in mm into a chart in px.

    Parameters
    ----------
    piece : Piece
    plane : (N, 2)
        mm, x right, y up.
    px_per_mm : float
    """
    used = plane[np.unique(piece.faces)]
    corner = np.array([used[:, 0].min(), used[:, 1].max()])
    vertex_px = (plane - corner) * np.array([px_per_mm, -px_per_mm]) + MARGIN
    return Chart(piece.vertex_ids, piece.faces, piece.face_ids, vertex_px, px_per_mm)


def picture_shape(chart: Chart) -> tuple[int, int]:
    """Height and width of the picture that holds a chart and its margin, px."""
    width, height = np.ceil(chart.vertex_px.max(axis=0)).astype(int) + MARGIN + 1
    return int(height), int(width)
