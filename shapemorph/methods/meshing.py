"""Triangles through a cloud of surface points."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay, QhullError, cKDTree

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.methods.open3d_import import import_open3d

_NEIGHBOURS = 12  # for normals
_RING = 6  # a point of a good mesh has six neighbours
_BALLS = (0.75, 1.1, 1.6, 2.4)  # radii as multiples of the median ring
_THIN = 0.1  # height over longest side of triangles that are peeled off the rim


@dataclass(frozen=True, slots=True, eq=False)
class MeshedPoints:
    """Triangles between given points, and how they were found.

    Attributes
    ----------
    faces : (F, 3) int64
        Rows of the points.
    method : str
        One sentence.
    """

    faces: Ints
    method: str


def mesh_points(
    points: Floats, *, steepest: float, reach: float, least_used: float
) -> MeshedPoints:
    """Mesh a cloud: by Delaunay in its best plane where it is a graph over it, else by balls.

    Parameters
    ----------
    points : (N, 3)
        Distinct, finite.
    steepest : float
        Largest slope against the best plane that a graph may have, radians.
    reach : float
        Longest edge, in multiples of the local spacing (distance to the sixth neighbour).
    least_used : float
        Share of the points that the triangulation in the plane must use, and that must be
        less steep than `steepest`, for the cloud to be a graph.

    Raises
    ------
    DataError
        If the points do not span a surface.
    """
    if len(points) < 4:
        raise DataError(f"expected a cloud of at least 4 points, got {len(points)}")
    near = min(_NEIGHBOURS + 1, len(points))
    found = cKDTree(points).query(points, k=near)
    distance, neighbour = np.asarray(found[0]), np.asarray(found[1], dtype=np.int64)
    spacing = distance[:, min(_RING, near - 1)]
    axes = _principal_axes(points)
    slope = np.abs(_normals(points, neighbour) @ axes[2])
    if np.mean(slope >= np.cos(steepest)) >= least_used:
        faces = _in_plane(points, axes, reach * spacing)
        if len(np.unique(faces)) >= least_used * len(points):
            text = f"Delaunay in the best plane, edges up to {reach:g} times the local spacing"
            return MeshedPoints(faces, text)
    return _by_balls(points, float(np.median(spacing)))


def _principal_axes(points: Floats) -> Floats:
    """Right-handed axes (3, 3) in rows, the normal of the best plane last."""
    _, _, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    axes[2] = np.cross(axes[0], axes[1])
    found: Floats = axes
    return found


def _normals(points: Floats, neighbour: Ints) -> Floats:
    """Find unit normals (N, 3), of either sign, of the planes through neighbours (N, K)."""
    normals = np.empty_like(points)
    for rows in np.array_split(np.arange(len(points)), len(points) // 50_000 + 1):
        patch = points[neighbour[rows]]
        patch = patch - patch.mean(axis=1, keepdims=True)
        _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", patch, patch))
        normals[rows] = vectors[:, :, 0]
    return normals


def _in_plane(points: Floats, axes: Floats, longest: Floats) -> Ints:
    """Delaunay triangles in the plane of the first two axes, without long edges and thin rims."""
    centred = points - points.mean(axis=0)
    try:
        faces = Delaunay(centred @ axes[:2].T).simplices.astype(np.int64)
    except QhullError:
        raise DataError("expected points on a surface, got points on one line") from None
    a, b, c = (points[faces[:, k]] for k in range(3))
    turned = np.cross(b - a, c - a) @ axes[2] < 0
    faces[turned] = faces[turned][:, [0, 2, 1]]
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)
    length = np.linalg.norm(points[ends[..., 0]] - points[ends[..., 1]], axis=-1)
    faces = faces[(length <= longest[ends].max(axis=-1)).all(axis=1)]
    return _peeled(points, faces)


def _peeled(points: Floats, faces: Ints) -> Ints:
    """Remove thin triangles from the rim until it has none (or ten times)."""
    for _ in range(10):
        drop = _on_rim(faces, len(points)) & _thin(points, faces)
        if not drop.any():
            break
        faces = faces[~drop]
    return faces


def _on_rim(faces: Ints, count: int) -> Bools:
    """Faces with an edge that no other face has."""
    end = np.roll(faces, -1, axis=1)
    key = np.minimum(faces, end) * count + np.maximum(faces, end)
    _, back, times = np.unique(key, return_inverse=True, return_counts=True)
    rim: Bools = (times[back].reshape(key.shape) == 1).any(axis=1)
    return rim


def _thin(points: Floats, faces: Ints) -> Bools:
    """Faces whose height is a small share of their longest side."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    longest = np.max([np.sum((p - q) ** 2, axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    flat: Bools = np.linalg.norm(np.cross(b - a, c - a), axis=1) < _THIN * longest
    return flat


def _by_balls(points: Floats, spacing: float) -> MeshedPoints:
    """Ball pivoting with radii from the median spacing.

    References
    ----------
    .. [1] Bernardini, F. et al. (1999). The ball-pivoting algorithm for surface
       reconstruction. IEEE TVCG 5, 349-359. :doi:`10.1109/2945.817351`
    """
    open3d = import_open3d()
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    radii = [factor * spacing for factor in _BALLS]
    try:
        cloud.estimate_normals(open3d.geometry.KDTreeSearchParamKNN(_NEIGHBOURS))
        cloud.orient_normals_consistent_tangent_plane(_NEIGHBOURS)
        mesh = open3d.geometry.TriangleMesh.create_from_point_cloud_ball_pivoting(
            cloud, open3d.utility.DoubleVector(radii)
        )
        faces = np.asarray(mesh.triangles).astype(np.int64)
    except RuntimeError:  # its Delaunay of a handful of points in one plane
        faces = np.zeros((0, 3), dtype=np.int64)
    if len(faces) == 0:
        raise DataError(
            f"expected points dense enough to mesh, got none that balls of up to {radii[-1]:.3g} "
            "could join: give more points or a mesh"
        )
    return MeshedPoints(faces, "ball pivoting, radii " + ", ".join(f"{r:.3g}" for r in radii))
