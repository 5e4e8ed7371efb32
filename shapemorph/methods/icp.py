"""Iterative closest points, point to plane."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.open3d_import import import_open3d

_TUKEY = 4.685  # standard deviations at which Tukey's weight reaches zero
_LEVELS = 6  # each knows the scatter that the one before has left
_SETTLED = 1e-9  # relative change of the residual at which a level ends
_FREE = 1e-4  # of the stiffest direction: below it the surface lets the motion slide
_DECIMALS = 10  # threads add up in any order; agreement ends well behind this digit


@dataclass(frozen=True, slots=True, eq=False)
class IcpFit:
    """A motion found from surfaces alone.

    Attributes
    ----------
    transform : RigidTransform
        ``target_from_source``.
    rms : float
        Distance to the planes of the points that carried it, mm.
    carried : int
        Number of source points within reach of the target.
    free : int
        Directions, of six, that the surface does not settle; there the start was kept.
    """

    transform: RigidTransform
    rms: float
    carried: int
    free: int


def fit_icp(
    source: Floats,
    target: Floats,
    target_normals: Floats,
    start: RigidTransform,
    *,
    reach: float,
    iterations: int,
) -> IcpFit:
    """Lay points on a surface, with little weight for those that do not fit.

    Parameters
    ----------
    source : (N, 3)
        mm.
    target, target_normals : (M, 3)
        Points of the surface with unit normals.
    start : RigidTransform
        ``target_from_source``, right to within `reach`.
    reach : float
        Largest distance between partners, mm.
    iterations : int
        Most steps at each level. Weights are Tukey's, scaled by the scatter (median) that
        the level before has left; a region of which more than a tenth has moved away as
        one piece can still pull the fit towards it.

    Returns
    -------
    IcpFit

    Notes
    -----
    A plane, a cylinder or a sphere can slide along itself. The motion is therefore
    applied only in the directions that the normals settle; in the others the start stays.
    """
    surface = _Surface(target, target_normals, reach, cKDTree(target))
    found, scale = start, reach
    for _ in range(_LEVELS):
        found = _registered(source, surface, found, scale, iterations)
        found, free = _settled_part(source, surface, start, found)
        _, distance = _partners(source, surface, found)
        scale = _scatter(distance, floor=1e-6 * reach)
    kept = distance[np.abs(distance) <= scale]
    rms = float(np.sqrt(np.mean(kept**2))) if len(kept) else np.nan
    return IcpFit(found, rms, len(kept), free)


@dataclass(frozen=True, slots=True, eq=False)
class _Surface:
    """What is laid upon: points with normals, and how far they reach out."""

    points: Floats
    normals: Floats
    reach: float
    tree: cKDTree


def _scatter(distance: Floats, *, floor: float) -> float:
    """Distance at which Tukey's weight ends."""
    if len(distance) == 0:
        return floor
    return max(_TUKEY * 1.4826 * float(np.median(np.abs(distance))), floor)


def _registered(
    source: Floats, surface: _Surface, start: RigidTransform, scale: float, iterations: int
) -> RigidTransform:
    registration = import_open3d().pipelines.registration
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = start.rotation, start.translation
    result = registration.registration_icp(
        _cloud(source),
        _cloud(surface.points, surface.normals),
        surface.reach,
        matrix,
        registration.TransformationEstimationPointToPlane(registration.TukeyLoss(scale)),
        registration.ICPConvergenceCriteria(_SETTLED, _SETTLED, iterations),
    )
    return _proper(np.asarray(result.transformation))


def _cloud(points: Floats, normals: Floats | None = None) -> object:
    open3d = import_open3d()
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    if normals is not None:
        cloud.normals = open3d.utility.Vector3dVector(normals)
    return cloud


def _proper(matrix: Floats) -> RigidTransform:
    """Round away what the order of summation has left, and make the rotation exact."""
    rotation = Rotation.from_matrix(matrix[:3, :3]).as_rotvec().round(_DECIMALS)
    return RigidTransform(
        Rotation.from_rotvec(rotation).as_matrix(), matrix[:3, 3].round(_DECIMALS)
    )


def _partners(source: Floats, surface: _Surface, transform: RigidTransform) -> tuple[Ints, Floats]:
    """Nearest target of each carried source point in reach, and distance to its plane."""
    carried = transform.apply(source)
    apart, nearest = surface.tree.query(carried, distance_upper_bound=surface.reach)
    near = np.isfinite(apart)
    index = np.asarray(nearest)[near]
    offset = carried[near] - surface.points[index]
    return index, np.sum(offset * surface.normals[index], axis=1)


def _settled_part(
    source: Floats, surface: _Surface, start: RigidTransform, found: RigidTransform
) -> tuple[RigidTransform, int]:
    """Keep of the step from `start` to `found` what the surface settles."""
    index, _ = _partners(source, surface, found)
    if len(index) == 0:
        return start, 6
    centre = surface.points[index].mean(axis=0)
    arm, normals = surface.points[index] - centre, surface.normals[index]
    size = np.sqrt(np.mean((arm**2).sum(axis=1)))
    rows = np.concatenate([np.cross(arm, normals) / size, normals], axis=1)
    stiffness, axes = np.linalg.eigh(rows.T @ rows)
    settled = axes[:, stiffness > _FREE * stiffness[-1]]
    turn = Rotation.from_matrix(found.rotation @ start.rotation.T)
    moved = found.apply(start.inverse().apply(centre)) - centre
    step = settled @ (settled.T @ np.concatenate([turn.as_rotvec() * size, moved]))
    rotation = Rotation.from_rotvec(step[:3] / size).as_matrix()
    shift = centre + step[3:] - rotation @ centre
    combined = RigidTransform(rotation @ start.rotation, rotation @ start.translation + shift)
    return combined, 6 - settled.shape[1]
