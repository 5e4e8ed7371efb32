"""A grid of points seen by two cameras in two states: the surface in space."""

import numpy as np
from scipy import ndimage

from shapemorph.core.arrays import Bools, Codes, Floats
from shapemorph.core.camera import Camera, Rig
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.status import PointStatus
from shapemorph.core.stereo_track import StereoGrids
from shapemorph.core.surface import TrackedSurface
from shapemorph.methods.cameras.triangulation import Triangulated, triangulate

LEAST_PX = 0.5  # a ray may always miss another by so much
TIMES = 8.0  # the usual distance of rays, or random error: more is no measurement
FINEST_PX = 1e-3  # random errors below it weigh no more


def stereo_surface(rig: Rig, grids: StereoGrids) -> TrackedSurface:
    """Place a grid in space before and after.

    Parameters
    ----------
    rig : Rig
        Its first two cameras took the pictures, left and right.
    grids : StereoGrids

    Returns
    -------
    TrackedSurface
        mm, both states in the world of the rig. Points whose rays miss each other by much
        more than is usual are OUTLIER; those whose random error is as much larger than usual
        are LOW_CONTRAST: their subsets show too little to hold them. Lost points keep a
        reference position: their own where both cameras saw them, else that of the nearest one.
    """
    cameras = rig.cameras[:2]
    still = np.zeros_like(grids.across.sigma_px)
    before = _placed(cameras, grids.across.reference_px, still, grids.across)
    after = _placed(cameras, grids.left.deformed_px, grids.left.sigma_px, grids.right)
    shape = grids.across.status.shape
    status = _first_loss((grids.across.status, grids.left.status, grids.right.status))
    for found in (before, after):
        far = _is_far(found.epipolar_error.reshape(shape), status)
        status[far & (status == PointStatus.OK)] = PointStatus.OUTLIER
    status[(status == PointStatus.OK) & ~np.isfinite(after.points).all(axis=1).reshape(shape)] = (
        PointStatus.NOT_SEEDED
    )
    variance = (before.sigma**2 + after.sigma**2).mean(axis=1).reshape(shape)
    status[_is_far_noisier(variance, status)] = PointStatus.LOW_CONTRAST
    lost = status != PointStatus.OK
    reference = _filled(before.points.reshape(*shape, 3), status)
    deformed = np.where(lost[..., None], np.nan, after.points.reshape(*shape, 3))
    towards = cameras[0].position
    return TrackedSurface(
        reference=reference,
        deformed=deformed,
        reference_normal=grid_normals(reference, towards),
        deformed_normal=np.where(lost[..., None], np.nan, grid_normals(deformed, towards)),
        sigma_position=np.where(lost, np.nan, np.sqrt(variance)),
        status=status,
        mesh_noise=np.zeros(2),
    )


def grid_normals(points: Floats, towards: Floats) -> Floats:
    """Find unit normals (R, C, 3) of a grid of points, on the side of a place (3,).

    From the nearest neighbours along rows and columns that are there; where there is none
    across, the direction towards that place.
    """
    along, down = _slopes(points, 1), _slopes(points, 0)
    normal = np.cross(along, down)
    view = towards - points
    view = view / np.linalg.norm(view, axis=-1, keepdims=True)
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        normal = normal / length
    normal = np.where(np.isfinite(normal), normal, view)
    outer: Floats = normal * np.where((normal * view).sum(axis=-1, keepdims=True) < 0, -1.0, 1.0)
    return outer


def _slopes(points: Floats, axis: int) -> Floats:
    """Difference between the neighbours on both sides, or to one of them; NaN without any."""
    ahead = np.roll(points, -1, axis=axis)
    behind = np.roll(points, 1, axis=axis)
    edge = [slice(None)] * 2
    edge[axis] = slice(-1, None)
    ahead[tuple(edge)] = np.nan
    edge[axis] = slice(0, 1)
    behind[tuple(edge)] = np.nan
    both, first, second = ahead - behind, ahead - points, points - behind
    return np.where(np.isfinite(both), both, np.where(np.isfinite(first), first, second))


def _placed(
    cameras: tuple[Camera, ...], left_px: Floats, left_sigma: Floats, right: CorrelationGrid
) -> Triangulated:
    pixels = np.stack([left_px.reshape(-1, 2), right.deformed_px.reshape(-1, 2)])
    # both cameras share the error of a match, even where one position is given
    pair = left_sigma.reshape(-1, 2) ** 2 + right.sigma_px.reshape(-1, 2) ** 2
    shared = np.maximum(np.sqrt(0.5 * pair), FINEST_PX)
    return triangulate(cameras, pixels, np.stack([shared, shared]))


def _first_loss(parts: tuple[Codes, ...]) -> Codes:
    status = parts[0].copy()
    for part in parts[1:]:
        status = np.where(status == PointStatus.OK, part, status)
    return status


def _is_far(error: Floats, status: Codes) -> Bools:
    usual = np.nanmedian(error[status == PointStatus.OK]) if (status == 0).any() else 0.0
    return np.asarray(~(error <= max(LEAST_PX, TIMES * float(usual))))


def _is_far_noisier(variance: Floats, status: Codes) -> Bools:
    """Tell which OK points have random errors that are many times the usual one."""
    ok = status == PointStatus.OK
    usual = float(np.median(variance[ok])) if ok.any() else np.inf
    return np.asarray(ok & (variance > TIMES**2 * usual))


def _filled(points: Floats, status: Codes) -> Floats:
    """Give points inside the mask that were not placed the position of the nearest one."""
    known: Bools = np.asarray(np.isfinite(points).all(axis=-1))
    inside = status != PointStatus.OUTSIDE_MASK
    if not known.any():
        return points
    _, nearest = ndimage.distance_transform_edt(~known, return_indices=True)
    filled = points[tuple(nearest)]
    return np.where(inside[..., None], filled, np.nan)
