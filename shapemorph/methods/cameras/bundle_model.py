"""What cameras and targets in their places let one see, and how that changes with each unknown."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.calibration import Sighting, View
from shapemorph.core.camera import Camera, distort, distortion_slope
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.cameras.dot_bias import middle_of_dots

LENS = 10  # fx, fy, cx, cy, k1, k2, k3, p1, p2, skew
PLACE = 6  # a turn about the axes of the frame, then a shift
BLOCK = LENS + PLACE  # unknowns of a camera


@dataclass(frozen=True, slots=True, eq=False)
class Observations:
    """Every point of every sighting in one list.

    Attributes
    ----------
    camera, view : (M,) int64
    point, normal : (M, 3) float64
        In the frame of the target, mm.
    radius : (M,) float64
        Of the dot, mm; 0 for corners.
    pixel : (M, 2) float64
    """

    camera: Ints
    view: Ints
    point: Floats
    normal: Floats
    radius: Floats
    pixel: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Arrangement:
    """Cameras, and places of targets as world_from_target."""

    cameras: tuple[Camera, ...]
    poses: tuple[RigidTransform, ...]


def observations_of(sightings: Sequence[Sighting], views: Sequence[View]) -> Observations:
    """Put the points of all sightings into one list."""
    points, normals, radii = [], [], []
    for sighting in sightings:
        target = views[sighting.view].target
        points.append(target.points[sighting.ids])
        up = np.tile([0.0, 0.0, 1.0], (len(sighting.ids), 1))
        normals.append(up if target.normals is None else target.normals[sighting.ids])
        radii.append(np.full(len(sighting.ids), target.dot_radius))
    counts = [len(sighting.ids) for sighting in sightings]
    return Observations(
        np.repeat([sighting.camera for sighting in sightings], counts),
        np.repeat([sighting.view for sighting in sightings], counts),
        np.concatenate(points),
        np.concatenate(normals),
        np.concatenate(radii),
        np.concatenate([sighting.pixels for sighting in sightings]),
    )


def _carried(seen: Observations, at: Arrangement) -> tuple[Floats, Floats, Floats]:
    """Points turned by the pose of their view, in the world, and in their camera (M, 3)."""
    turns = np.stack([pose.rotation for pose in at.poses])[seen.view]
    shifts = np.stack([pose.translation for pose in at.poses])[seen.view]
    turned = np.einsum("mij,mj->mi", turns, seen.point)
    world = turned + shifts
    own_turns = np.stack([camera.pose.rotation for camera in at.cameras])[seen.camera]
    own_shifts = np.stack([camera.pose.translation for camera in at.cameras])[seen.camera]
    return turned, world, np.einsum("mij,mj->mi", own_turns, world) + own_shifts


def residuals_of(seen: Observations, at: Arrangement) -> Floats:
    """Seen minus predicted (M, 2), px; NaN where a point lies behind its camera."""
    _, _, own = _carried(seen, at)
    depth = np.where(own[:, 2] > 0, own[:, 2], np.nan)
    flat = own[:, :2] / depth[:, None]
    if seen.radius.any():
        flat = middle_of_dots(own, _normals_in_camera(seen, at), seen.radius)
    predicted = np.empty_like(seen.pixel)
    for number, camera in enumerate(at.cameras):
        mine = seen.camera == number
        bent = distort(flat[mine], camera.radial, camera.tangential)
        predicted[mine] = camera.pixels_of(bent)
    return seen.pixel - predicted


def _normals_in_camera(seen: Observations, at: Arrangement) -> Floats:
    turns = np.stack([pose.rotation for pose in at.poses])[seen.view]
    own = np.stack([camera.pose.rotation for camera in at.cameras])[seen.camera]
    normals: Floats = np.einsum("mij,mjk,mk->mi", own, turns, seen.normal)
    return normals


def slopes_of(seen: Observations, at: Arrangement) -> tuple[Floats, Floats]:
    """Differentiate the pixel by the unknowns of camera (M, 2, 16) and view (M, 2, 6).

    The shift of a dot's middle is taken as constant here; it changes a thousand times less.
    """
    turned, _, own = _carried(seen, at)
    flat = own[:, :2] / own[:, 2:]
    by_camera = np.zeros((len(flat), 2, BLOCK))
    by_view = np.empty((len(flat), 2, PLACE))
    for number, camera in enumerate(at.cameras):
        mine = seen.camera == number
        by_camera[mine, :, :LENS] = _lens_slopes(camera, flat[mine])
        by_point = _point_slopes(camera, flat[mine], own[mine, 2])
        by_camera[mine, :, LENS:] = _turn_and_shift(by_point, own[mine] - camera.pose.translation)
        by_view[mine] = _turn_and_shift(by_point @ camera.pose.rotation, turned[mine])
    return by_camera, by_view


def _lens_slopes(camera: Camera, flat: Floats) -> Floats:
    x, y = flat.T
    square = x * x + y * y
    bent = distort(flat, camera.radial, camera.tangential)
    slopes = np.zeros((len(flat), 2, LENS))
    slopes[:, 0, 0], slopes[:, 1, 1] = bent.T
    slopes[:, 0, 2] = slopes[:, 1, 3] = 1.0
    powers = np.stack([square, square**2, square**3], axis=-1)
    moved = np.zeros((len(flat), 2, 5))
    moved[:, :, :3] = flat[:, :, None] * powers[:, None, :]
    moved[:, 0, 3], moved[:, 1, 3] = 2 * x * y, square + 2 * y * y
    moved[:, 0, 4], moved[:, 1, 4] = square + 2 * x * x, 2 * x * y
    slopes[:, :, 4:9] = camera.matrix[:2, :2] @ moved
    slopes[:, 0, 9] = bent[:, 1]
    return slopes


def _point_slopes(camera: Camera, flat: Floats, depth: Floats) -> Floats:
    """Differentiate (M, 2, 3) the pixel by the point in the frame of the camera."""
    lens = camera.matrix[:2, :2] @ distortion_slope(flat, camera.radial, camera.tangential)
    pinhole = np.zeros((len(flat), 2, 3))
    pinhole[:, 0, 0] = pinhole[:, 1, 1] = 1 / depth
    pinhole[:, :, 2] = -flat / depth[:, None]
    slopes: Floats = lens @ pinhole
    return slopes


def _turn_and_shift(by_point: Floats, arm: Floats) -> Floats:
    """Differentiate (M, 2, 6) by a small turn of the arm (M, 3) and by a shift."""
    turn = np.cross(arm[:, None, :], by_point)
    return np.concatenate([turn, by_point], axis=-1)


def moved(at: Arrangement, own: Floats, places: Floats) -> Arrangement:
    """Take a step of the unknowns of all cameras (C * 16,) and views (V, 6)."""
    cameras = tuple(
        _moved_camera(camera, step)
        for camera, step in zip(at.cameras, own.reshape(-1, BLOCK), strict=True)
    )
    poses = tuple(moved_pose(pose, step) for pose, step in zip(at.poses, places, strict=True))
    return Arrangement(cameras, poses)


def _moved_camera(camera: Camera, step: Floats) -> Camera:
    least = 0.1 * camera.focal
    return replace(
        camera,
        focal=np.maximum(camera.focal + step[:2], least),
        centre=camera.centre + step[2:4],
        radial=camera.radial + step[4:7],
        tangential=camera.tangential + step[7:9],
        skew=camera.skew + float(step[9]),
        pose=moved_pose(camera.pose, step[LENS:]),
    )


def moved_pose(pose: RigidTransform, step: Floats) -> RigidTransform:
    """Turn a pose a little about the axes of its frame, and shift it."""
    turn = Rotation.from_rotvec(step[:3]).as_matrix()
    return RigidTransform(turn @ pose.rotation, pose.translation + step[3:])
