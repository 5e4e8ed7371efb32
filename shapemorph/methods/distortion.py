"""How a flattening stretches each triangle."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.flattened import Distortion
from shapemorph.core.image import Chart


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
    return _distortion(vertices[faces], plane[faces])


def chart_distortion(vertices: Floats, chart: Chart) -> Distortion:
    """Find how a chart stretches its triangles, px per mm.

    Parameters
    ----------
    vertices : (V, 3)
        Of the mesh, mm.
    chart : Chart
    """
    corners = vertices[chart.vertex_ids][chart.faces]
    return _distortion(corners, chart.corner_px * np.array([1.0, chart_handedness(chart)]))


def chart_handedness(chart: Chart) -> float:
    """Tell which way round the triangles of a chart run in (x right, y down) coordinates.

    Returns
    -------
    float
        -1 where the picture shows the outer side of the surface (most area turns
        counter-clockwise as seen on a screen), +1 where it shows the inner side.
    """
    return 1.0 if _signed_areas(chart.corner_px).sum() >= 0 else -1.0


def _signed_areas(corners: Floats) -> Floats:
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas: Floats = 0.5 * (one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    return areas


def _distortion(corners: Floats, flat: Floats) -> Distortion:
    """Singular values from an orthonormal frame in each triangle."""
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        length = np.linalg.norm(one, axis=1)
        along = (one * other).sum(axis=1) / length
        height = np.linalg.norm(np.cross(one, other), axis=1) / length
        first = (flat[:, 1] - flat[:, 0]) / length[:, None]
        second = (flat[:, 2] - flat[:, 0] - first * along[:, None]) / height[:, None]
        same = 0.5 * np.hypot(first[:, 0] + second[:, 1], first[:, 1] - second[:, 0])
        turned = 0.5 * np.hypot(first[:, 0] - second[:, 1], first[:, 1] + second[:, 0])
        values = np.stack([same + turned, same - turned])
    area = np.nan_to_num(0.5 * length * height)
    sigma_1, sigma_2 = np.where(area > 0, values, np.nan)
    return Distortion(sigma_1, sigma_2, area)


def weighted_quantile(values: Floats, weights: Floats, share: float) -> float:
    """Value below which `share` of the weight lies; NaN values have no weight."""
    known = np.isfinite(values) & (weights > 0)
    if not known.any():
        return float("nan")
    order = np.argsort(values[known], kind="stable")
    total = np.cumsum(weights[known][order])
    place = min(int(np.searchsorted(total, share * total[-1])), len(order) - 1)
    return float(values[known][order][place])


def local_scale(distortion: Distortion) -> Floats:
    """Geometric mean of the two stretches of each triangle; NaN where it is flipped."""
    product = distortion.sigma_1 * distortion.sigma_2
    scale: Floats = np.sqrt(np.where(product > 0, product, np.nan))
    return scale
