"""Profile map: around an axis, the radius in the picture is the arc length of the meridian.

It is the paper's own flattening of the bulge, there along a meridian from a finite-element
model (K. Genovese, D. Sorgente, Opt. Lasers Eng. 2017, doi
10.1016/j.optlaseng.2017.06.020).
"""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.methods.parametrize.frames import screen, show_outer_side, vertex_areas
from shapemorph.methods.parametrize.meridian import (
    Meridian,
    arc_length,
    curve_meridian,
    measure_arc,
)
from shapemorph.methods.parametrize.revolution_axis import fit_revolution_axis
from shapemorph.methods.parametrize.round_fit import tukey

SHIFTS = 12  # steps that lay a given meridian on the surface
STARTS = 5
RINGS = 60  # into which the way is cut to follow a given meridian
STEEPEST = 5.0  # change of length, and its inverse, that a given meridian may ask for


def parametrise_profile(
    vertices: Floats,
    faces: Ints,
    *,
    centre: Floats | None,
    axis: Floats | None,
    meridian: Floats | None,
) -> Floats:
    """Map a surface of revolution, about so, by arc length along its meridian.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
        A disk with holes.
    centre : (3,) or None
        A point of the axis; None: of the axis that most normals meet.
    axis : (3,) or None
        Its direction; None: as `centre`.
    meridian : (K, 2) or None
        r >= 0 and z along the axis, from the inside outward, in the unit of the vertices;
        origin and sense of z are free. None: measured from the mesh.

    Returns
    -------
    (V, 2)
        In the unit of the vertices, true along meridians; x right, y up, faces
        counter-clockwise. Where the meridian begins off the axis, so does the picture.
    """
    weights = vertex_areas(vertices, faces)
    point, along = fit_revolution_axis(vertices, faces, centre=centre, axis=axis)
    right, up = screen(along)
    rings = (vertices - point) @ np.stack([right, up, along], axis=1)
    radius = np.linalg.norm(rings[:, :2], axis=1)
    half_plane = np.column_stack([radius, rings[:, 2]])
    arc = measure_arc(rings, faces)
    if meridian is not None:
        given = arc_length(lay_meridian(meridian, half_plane, weights), half_plane)
        arc = follow(arc, given, weights)
    stretch = np.where(radius > 0, arc / np.where(radius > 0, radius, 1.0), 1.0)
    return show_outer_side(vertices, faces, stretch[:, None] * rings[:, :2])


def follow(way: Floats, given: Floats, weights: Floats) -> Floats:
    """Replace a way by a smooth rising function of it that is close to a given one.

    Nearest points of a curve bunch and part at its bends; their mean over a ring does not.
    Its slope is kept between a fifth and five.

    Parameters
    ----------
    way, given : (V,)
        Along the mesh, and along the given meridian.
    weights : (V,)

    Returns
    -------
    (V,)
    """
    from scipy.interpolate import PchipInterpolator

    ring = ((way - way.min()) / np.ptp(way) * RINGS).astype(np.int64).clip(0, RINGS - 1)
    total = np.bincount(ring, weights, minlength=RINGS)
    used = total > 0
    nodes, values = (
        np.bincount(ring, weights * each, minlength=RINGS)[used] / total[used]
        for each in (way, given)
    )
    slopes = np.clip(np.diff(values) / np.diff(nodes), 1 / STEEPEST, STEEPEST)
    beyond = np.ptp(way) / RINGS
    nodes = np.concatenate([nodes[:1] - beyond, nodes, nodes[-1:] + beyond])
    slopes = np.concatenate([slopes[:1], slopes, slopes[-1:]])
    rise = np.concatenate([[0.0], np.cumsum(slopes * np.diff(nodes))])
    law = PchipInterpolator(nodes, rise)(way)
    followed: Floats = law - law.min() + max(values[0] - slopes[0] * (nodes[1] - way.min()), 0.0)
    return followed


def lay_meridian(meridian: Floats, points: Floats, weights: Floats) -> Meridian:
    """Shift a curve along the axis, either way up, to where points (N, 2) of r, z lie.

    Parameters
    ----------
    meridian : (K, 2)
        r, z.
    points : (N, 2)
    weights : (N,)
    """
    tried = [
        _shift(meridian * np.array([1.0, sense]), start, points, weights)
        for sense in (1.0, -1.0)
        for start in np.linspace(0.0, 1.0, STARTS)
    ]
    return curve_meridian(min(tried, key=lambda each: each[1])[0])


def _shift(meridian: Floats, start: float, points: Floats, weights: Floats) -> tuple[Floats, float]:
    """Move a curve to the nearest points of the surface; return it and the mean distance."""
    from scipy.spatial import cKDTree

    dense = _refine(meridian)
    size = float(np.ptp(dense))
    low, high = points[:, 1].min(), points[:, 1].max()
    shift = (1 - start) * (low - dense[:, 1].min()) + start * (high - dense[:, 1].max())
    tree = cKDTree(dense)
    for _ in range(SHIFTS):
        distance, nearest = tree.query(points - [0.0, shift])
        trust = weights * tukey(np.asarray(distance) / size)
        trust = trust if trust.any() else weights
        shift += np.average(points[:, 1] - shift - dense[nearest, 1], weights=trust)
    distance, _ = tree.query(points - [0.0, shift])
    return meridian + np.array([0.0, shift]), float(np.average(distance, weights=weights))


def _refine(meridian: Floats) -> Floats:
    """Points along a polyline, close to each other."""
    curve = curve_meridian(meridian)
    arc = np.linspace(curve.arc[0], curve.arc[-1], 1000)
    return np.column_stack([np.interp(arc, curve.arc, curve.points[:, k]) for k in (0, 1)])
