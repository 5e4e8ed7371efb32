"""Arc length along the meridians of a surface of revolution: by a curve, or by the mesh."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.methods.parametrize.disk import boundary_loops
from shapemorph.methods.parametrize.frames import directed_areas
from shapemorph.methods.parametrize.symmetric_solve import symmetric_solver

POLE = 1.5  # edges around a pole in which the way along the surface is a straight line


@dataclass(frozen=True, slots=True, eq=False)
class Meridian:
    """A curve in the half plane of an axis.

    Attributes
    ----------
    points : (K, 2)
        r, z from the pole outward.
    arc : (K,)
        Length along it; it begins with the radius of the first point.
    """

    points: Floats
    arc: Floats


def curve_meridian(points: Floats) -> Meridian:
    """Measure the arc along a curve (K, 2) of r, z."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    kept = np.concatenate([[True], steps > 0])
    arc = abs(float(points[0, 0])) + np.concatenate([[0.0], np.cumsum(steps)])
    return Meridian(points[kept], arc[kept])


def arc_length(meridian: Meridian, points: Floats) -> Floats:
    """Arc length (N,) of the place of a meridian that is nearest to each point (N, 2) r, z.

    Beyond the outer end the curve goes on straight, and before the inner one too, down
    to the axis.
    """
    from scipy.spatial import cKDTree

    _, nearest = cKDTree(meridian.points).query(points)
    last = len(meridian.points) - 2
    best = np.full(len(points), np.inf)
    found = np.zeros(len(points))
    for segment in (np.clip(nearest - 1, 0, last), np.clip(nearest, 0, last)):
        begin = meridian.points[segment]
        along = meridian.points[segment + 1] - begin
        length = meridian.arc[segment + 1] - meridian.arc[segment]
        share = ((points - begin) * along).sum(axis=1) / length**2
        share = np.clip(
            share, np.where(segment == 0, -np.inf, 0.0), np.where(segment == last, np.inf, 1.0)
        )
        off = np.linalg.norm(points - begin - share[:, None] * along, axis=1)
        nearer = off < best
        best = np.where(nearer, off, best)
        found = np.where(nearer, meridian.arc[segment] + share * length, found)
    return np.maximum(found, 0.0)


def measure_arc(rings: Floats, faces: Ints) -> Floats:
    """Measure the way along the meridians of a mesh to each of its vertices.

    It is the function whose slope in every triangle is nearest to 1 outward across the
    circles around the axis: least squares over the whole surface, so that noise averages
    out and sharp bends do no harm.

    Parameters
    ----------
    rings : (V, 3)
        x, y across the axis and z along it.
    faces : (F, 3)

    Returns
    -------
    (V,)
        It begins at a pole with 0, at an opening with its radius.
    """
    corners = rings[faces]
    normals = directed_areas(rings, faces)
    normals /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)[:, None]
    radial, outward = _meridian_frames(corners.mean(axis=1), normals)
    way, kinked = _integrate(rings, faces, normals, np.stack([outward, radial], axis=-1)).T
    # the radius has the same kink at a pole: what integration rounds off there is known
    correction = np.linalg.norm(rings[:, :2], axis=1) - kinked
    return _from_its_beginning(way, correction, rings, faces)


def _meridian_frames(middles: Floats, normals: Floats) -> tuple[Floats, Floats]:
    """Give the slope of the radius in each face, and the unit vector along its meridian."""
    around = np.stack([-middles[:, 1], middles[:, 0], np.zeros(len(middles))], axis=1)
    around /= np.maximum(np.linalg.norm(around, axis=1), np.finfo(float).tiny)[:, None]
    across = np.stack([around[:, 1], -around[:, 0], np.zeros(len(middles))], axis=1)
    radial = across - (across * normals).sum(axis=1)[:, None] * normals
    along = np.cross(around, normals)
    along /= np.maximum(np.linalg.norm(along, axis=1), np.finfo(float).tiny)[:, None]
    return radial, along


def _integrate(vertices: Floats, faces: Ints, normals: Floats, slopes: Floats) -> Floats:
    """Find functions (V, K) on a mesh whose slopes come nearest to those given (F, 3, K)."""
    import igl

    corners = vertices[faces]
    opposite = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    flux = 0.5 * np.cross(normals[:, None], opposite) @ slopes
    corner, count = faces.ravel(), len(vertices)
    right: Floats = np.stack(
        [np.bincount(corner, flux[..., k].ravel(), minlength=count) for k in range(flux.shape[2])],
        axis=1,
    ).astype(np.float64)
    laplacian = (-igl.cotmatrix(vertices, faces)).tocsr()
    found = np.zeros(right.shape)
    found[1:] = symmetric_solver(laplacian[1:].tocsc()[:, 1:])(right[1:])
    return found


def _from_its_beginning(arc: Floats, correction: Floats, rings: Floats, faces: Ints) -> Floats:
    """Give the arc its sense and the constant that integration leaves open."""
    radius = np.linalg.norm(rings[:, :2], axis=1)
    loops = boundary_loops(faces, name="the surface")
    around = sorted(
        (loop for loop in loops if _winds(rings[loop, :2])),
        key=lambda loop: float(radius[loop].mean()),
    )
    if len(around) == 1:
        return _from_pole(arc, correction, rings, around[0], faces)
    begin = around[0] if around else np.argsort(radius, kind="stable")[: len(radius) // 50 + 1]
    if arc[begin].mean() > arc.mean():
        arc = -arc
    arc = arc + correction
    from_opening: Floats = arc - arc[begin].mean() + radius[begin].mean()
    return from_opening


def _from_pole(arc: Floats, correction: Floats, rings: Floats, rim: Ints, faces: Ints) -> Floats:
    radius = np.linalg.norm(rings[:, :2], axis=1)
    edge = float(np.median(np.linalg.norm(rings[faces[:, 0]] - rings[faces[:, 1]], axis=1)))
    near = np.flatnonzero(radius <= radius.min() + edge)
    pole = near[np.linalg.norm(rings[near] - rings[rim].mean(axis=0), axis=1).argmax()]
    distance = np.linalg.norm(rings - [0.0, 0.0, rings[pole, 2]], axis=1)
    around = distance < POLE * edge + radius[pole]
    if arc[around].mean() > arc[rim].mean():
        arc = -arc
    arc = arc + correction
    from_pole: Floats = np.maximum(arc + np.median((distance - arc)[around]), 0.0)
    return from_pole


def _winds(outline: Floats) -> bool:
    """Whether a loop (K, 2) goes around the origin."""
    ahead = np.roll(outline, -1, axis=0)
    cross = outline[:, 0] * ahead[:, 1] - outline[:, 1] * ahead[:, 0]
    turned = np.arctan2(cross, (outline * ahead).sum(axis=1)).sum()
    return bool(abs(turned) > np.pi)
