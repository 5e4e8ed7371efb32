"""Points that lie a little outside a chart."""

import numpy as np
from scipy.spatial import cKDTree

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.image import Chart, SurfacePoints

_CHUNK = 2_000_000  # distances at a time, to bound memory


def extend_to(
    chart: Chart, found: SurfacePoints, points_px: Floats, *, reach: float
) -> SurfacePoints:
    """Place points just outside a chart by linear extension of its nearest triangle.

    Parameters
    ----------
    chart : Chart
    found : SurfacePoints
        What lies inside the chart already; it stays as it is.
    points_px : (N, 2)
        The same points, px; NaN where there is nothing to place.
    reach : float
        Farthest distance from the rim to accept, px.

    Returns
    -------
    SurfacePoints
        Extended points have barycentric weights that leave [0, 1] but still sum to one.
    """
    lost = np.flatnonzero((found.face < 0) & np.isfinite(points_px).all(axis=1))
    rim, owner = _rim(chart.faces)
    if not (len(lost) and len(rim) and reach > 0):
        return found
    lost = lost[_may_reach(chart.vertex_px[rim], points_px[lost], reach)]
    if len(lost) == 0:
        return found
    edge, distance = _nearest_edge(chart.vertex_px[rim], points_px[lost])
    near = distance <= reach
    face, barycentric = found.face.copy(), found.barycentric.copy()
    triangle = owner[edge[near]]
    face[lost[near]] = chart.face_ids[triangle]
    barycentric[lost[near]] = _weights(chart.corner_px[triangle], points_px[lost[near]])
    return SurfacePoints(face, barycentric)


def _rim(faces: Ints) -> tuple[Ints, Ints]:
    """Edges that belong to one triangle only, and that triangle."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    owner = np.tile(np.arange(len(faces)), 3)
    key = edges.min(axis=1) * (faces.max() + 1) + edges.max(axis=1)
    _, first, count = np.unique(key, return_index=True, return_counts=True)
    alone = first[count == 1]
    return edges[alone], owner[alone]


def _may_reach(edges_px: Floats, points_px: Floats, reach: float) -> Bools:
    """Points near enough to the middle of some edge for a closer look."""
    middle, along = edges_px.mean(axis=1), edges_px[:, 1] - edges_px[:, 0]
    longest = float(np.linalg.norm(along, axis=1).max())
    distance, _ = cKDTree(middle).query(points_px)
    near: Bools = np.asarray(distance) <= reach + longest / 2
    return near


def _nearest_edge(edges_px: Floats, points_px: Floats) -> tuple[Ints, Floats]:
    """Nearest segment (E, 2, 2) to each point, and its distance."""
    step = max(1, _CHUNK // len(edges_px))
    parts = [
        _distances(edges_px, points_px[start : start + step])
        for start in range(0, len(points_px), step)
    ]
    nearest = np.concatenate([part.argmin(axis=1) for part in parts])
    return nearest, np.concatenate([part.min(axis=1) for part in parts])


def _distances(edges_px: Floats, points_px: Floats) -> Floats:
    start, along = edges_px[:, 0], edges_px[:, 1] - edges_px[:, 0]
    from_start = points_px[:, None] - start
    squared = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    share = np.clip((from_start * along).sum(axis=2) / squared, 0, 1)
    distances: Floats = np.linalg.norm(from_start - share[:, :, None] * along, axis=2)
    return distances


def _weights(corner_px: Floats, points_px: Floats) -> Floats:
    """Barycentric weights of points in the planes of their triangles, (N, 3)."""
    sides = np.stack([corner_px[:, 1] - corner_px[:, 0], corner_px[:, 2] - corner_px[:, 0]], axis=2)
    offset = points_px - corner_px[:, 0]
    weights = np.linalg.solve(sides, offset[:, :, None])[:, :, 0]
    return np.concatenate([1 - weights.sum(axis=1, keepdims=True), weights], axis=1)
