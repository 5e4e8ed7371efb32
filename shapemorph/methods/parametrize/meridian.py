"""The meridian of a surface of revolution: measured from a mesh, and arc length along it."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.methods.parametrize.disk import boundary_loops
from shapemorph.methods.parametrize.round_fit import tukey

SAMPLES = 4000  # points of a measured meridian
MOST_KNOTS = 200
EDGES_PER_KNOT = 2.0
ROUNDS = 5
STIFFNESS = 1e-9  # of the penalty on bends: only gaps in the data feel it


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


def measure_meridian(rings: Floats, vertices: Floats, faces: Ints, weights: Floats) -> Meridian:
    """Fit the curve that the vertices of a surface of revolution lie on.

    Parameters
    ----------
    rings : (V, 3)
        x, y across the axis and z along it.
    vertices : (V, 3)
        In space, for lengths of edges.
    faces : (F, 3)
    weights : (V,)
        Areas.
    """
    radius = np.linalg.norm(rings[:, :2], axis=1)
    points = np.column_stack([radius, rings[:, 2]])
    edge = _edge_length(vertices, faces)
    travelled, has_pole = _first_arc(rings, vertices, faces, edge)
    meridian = _fit_curve(travelled, points, weights, edge, has_pole=has_pole)
    for _ in range(ROUNDS):
        travelled = arc_length(meridian, points)
        meridian = _fit_curve(travelled, points, weights, edge, has_pole=has_pole)
    return meridian


def _edge_length(vertices: Floats, faces: Ints) -> float:
    return float(np.median(np.linalg.norm(vertices[faces[:, 0]] - vertices[faces[:, 1]], axis=1)))


def _first_arc(rings: Floats, vertices: Floats, faces: Ints, edge: float) -> tuple[Floats, bool]:
    """Distance along the edges from where the meridians begin, and whether that is a pole."""
    radius = np.linalg.norm(rings[:, :2], axis=1)
    around = [loop for loop in boundary_loops(faces, name="the surface") if _winds(rings[loop, :2])]
    if not around:  # a sector: along its longest extent in the half plane
        return _along_sector(np.column_stack([radius, rings[:, 2]])), False
    around.sort(key=lambda loop: float(radius[loop].mean()))
    if len(around) == 1:
        near = np.flatnonzero(radius <= radius.min() + edge)
        rim = rings[around[0]].mean(axis=0)
        begin = near[[np.linalg.norm(rings[near] - rim, axis=1).argmax()]]
    else:
        begin = around[0]
    distance = _edge_distance(vertices, faces, begin)
    return float(radius[begin].mean()) + distance, len(around) == 1


def _winds(outline: Floats) -> bool:
    """Whether a loop (K, 2) goes around the origin."""
    ahead = np.roll(outline, -1, axis=0)
    cross = outline[:, 0] * ahead[:, 1] - outline[:, 1] * ahead[:, 0]
    turned = np.arctan2(cross, (outline * ahead).sum(axis=1)).sum()
    return bool(abs(turned) > np.pi)


def _along_sector(points: Floats) -> Floats:
    offsets = points - points.mean(axis=0)
    _, directions = np.linalg.eigh(offsets.T @ offsets)
    along = offsets @ directions[:, 1]
    if along @ points[:, 0] < 0:
        along = -along
    way: Floats = along - along.min() + points[:, 0].min()
    return way


def _edge_distance(vertices: Floats, faces: Ints, begin: Ints) -> Floats:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    count = len(vertices)
    linked = coo_array((length, (edges[:, 0], edges[:, 1])), shape=(count, count)).tocsr()
    distance: Floats = dijkstra(linked, directed=False, indices=begin, min_only=True)
    return distance


def _fit_curve(
    travelled: Floats, points: Floats, weights: Floats, edge: float, *, has_pole: bool
) -> Meridian:
    """Fit r and z as smooth functions of the way; through a pole r is odd and z even."""
    from scipy.interpolate import BSpline

    first, last = float(travelled.min()), float(travelled.max())
    along, target, trust = travelled, points, weights
    if has_pole:
        along = np.concatenate([travelled, -travelled])
        target = np.concatenate([points, points * [-1.0, 1.0]])
        trust = np.concatenate([weights, weights])
    low = -last if has_pole else first
    pieces = int(np.clip((last - low) / (EDGES_PER_KNOT * edge), 4, MOST_KNOTS))
    pieces += has_pole and pieces % 2
    knots = np.linspace(low, last, pieces + 1)
    step = knots[1] - knots[0]
    padded = np.concatenate(
        [low - step * np.arange(3, 0, -1), knots, last + step * np.arange(1, 4)]
    )
    basis = BSpline.design_matrix(np.clip(along, low, last), padded, 3).tocsc()
    curve = BSpline(padded, _solve_robustly(basis, target, trust), 3)
    ways = np.linspace(0.0 if has_pole else first, last, SAMPLES)
    return curve_meridian(curve(ways))


def _solve_robustly(basis, target: Floats, trust: Floats) -> Floats:  # type: ignore[no-untyped-def]
    """Coefficients of least squares; points that lie off the curve lose their weight."""
    bends = np.diff(np.eye(basis.shape[1]), n=2, axis=0)
    weight = trust
    size = float(np.ptp(target[:, 1]) + np.ptp(target[:, 0]))
    for _ in range(3):
        normal = (basis.T @ (basis.multiply(weight[:, None]))).toarray()
        normal += STIFFNESS * np.trace(normal) / len(normal) * (bends.T @ bends)
        found = np.linalg.solve(normal, basis.T @ (target * weight[:, None]))
        weight = trust * tukey(np.linalg.norm(target - basis @ found, axis=1) / size)
    solved: Floats = np.asarray(found)
    return solved
