"""How a flattening stretches each triangle."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.flattened import Distortion
from shapemorph.core.image import Chart
from shapemorph.kernels.facets import signed_area, stretch_triangles
from shapemorph.kernels.quantiles import select_by_weight


def singular_values(vertices: Floats, faces: Ints, plane: Floats) -> Distortion:
    """Find the singular values of the map of each triangle from space to the plane.

    Parameters
    ----------
    vertices : (V, 3)
        mm.
    faces : (M, 3)
    plane : (V, 2)
        Positions in the plane, any unit; (x right, y up) for the sign of `sigma_2`.

    Returns
    -------
    Distortion
        In units of the plane per mm; NaN for triangles without area.
    """
    return _stretches(vertices, faces, plane, 1.0)


def chart_distortion(vertices: Floats, chart: Chart) -> Distortion:
    """Find how a chart stretches its triangles, px per mm.

    Parameters
    ----------
    vertices : (V, 3)
        Of the mesh, mm.
    chart : Chart
    """
    points = vertices[chart.vertex_ids]
    return _stretches(points, chart.faces, chart.vertex_px, chart_handedness(chart))


def chart_handedness(chart: Chart) -> float:
    """Tell which way round the triangles of a chart run in (x right, y down) coordinates.

    Returns
    -------
    float
        -1 where the picture shows the outer side of the surface (most area turns
        counter-clockwise as seen on a screen), +1 where it shows the inner side.
    """
    px, faces = np.ascontiguousarray(chart.vertex_px), np.ascontiguousarray(chart.faces)
    return 1.0 if signed_area(px, faces) >= 0 else -1.0


def _stretches(points: Floats, faces: Ints, plane: Floats, sense: float) -> Distortion:
    inputs = (np.ascontiguousarray(each) for each in (points, faces, plane))
    return Distortion(*stretch_triangles(*inputs, sense))


def weighted_quantile(values: Floats, weights: Floats, share: float) -> float:
    """Value below which `share` of the weight lies; NaN values have no weight."""
    pair = (np.ascontiguousarray(each, dtype=np.float64) for each in (values, weights))
    return float(select_by_weight(*pair, share))


def local_scale(distortion: Distortion) -> Floats:
    """Geometric mean of the two stretches of each triangle; NaN where it is flipped."""
    product = distortion.sigma_1 * distortion.sigma_2
    scale: Floats = np.sqrt(np.where(product > 0, product, np.nan))
    return scale
