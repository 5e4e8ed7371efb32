"""Lay a flattening out as a picture: scale, orientation, margin.

The picture shows the outer side of the surface, as a camera would: faces that run
counter-clockwise seen from outside run counter-clockwise on the screen, so their signed
area in (x right, y down) coordinates is negative.
"""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.core.image import Chart
from shapemorph.kernels.facets import plane_moments
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
    flat, faces = np.ascontiguousarray(plane), np.ascontiguousarray(piece.faces)
    centre, second, along_space = plane_moments(vertices[piece.vertex_ids], flat, faces)
    _, axes = np.linalg.eigh(second)
    along = axes[:, 1]
    turned = np.stack([along, [-along[1], along[0]]], axis=1)
    along_height = turned[:, 1] @ along_space
    if along_height[np.abs(along_height).argmax()] < 0:
        turned = -turned
    placed: Floats = (plane - centre) @ turned
    return placed


def chart_at_scale(piece: Piece, plane: Floats, *, px_per_mm: float) -> Chart:
    """Turn a flattening in mm into a chart in px.

    Parameters
    ----------
    piece : Piece
    plane : (N, 2)
        mm, x right, y up.
    px_per_mm : float
    """
    low, high = bounds(piece, plane)
    corner = np.array([low[0], high[1]])
    vertex_px = (plane - corner) * np.array([px_per_mm, -px_per_mm]) + MARGIN
    return Chart(piece.vertex_ids, piece.faces, piece.face_ids, vertex_px, px_per_mm)


def bounds(piece: Piece, plane: Floats) -> tuple[Floats, Floats]:
    """Lowest and highest coordinates (2,) of the vertices that triangles use."""
    used = np.zeros(len(plane), dtype=np.bool_)
    used[piece.faces] = True
    x, y = plane[used].T
    return np.array([x.min(), y.min()]), np.array([x.max(), y.max()])


def picture_shape(chart: Chart) -> tuple[int, int]:
    """Height and width of the picture that holds a chart and its margin, px."""
    width, height = np.ceil(chart.vertex_px.max(axis=0)).astype(int) + MARGIN + 1
    return int(height), int(width)
