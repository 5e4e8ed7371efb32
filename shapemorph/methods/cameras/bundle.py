"""Bundle adjustment: all cameras and all places of the targets, by sparse least squares.

Each place of a target touches six unknowns that no other place touches; they are eliminated
from the normal equations (Schur complement), so that what is left to solve has a row for each
unknown of a camera, however many pictures there are.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.calibration import Sighting, View
from shapemorph.core.camera import Camera, distort, distortion_slope
from shapemorph.core.errors import StageError
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.cameras.dot_bias import middle_of_dots

LENS = 10  # fx, fy, cx, cy, k1, k2, k3, p1, p2, skew
PLACE = 6  # a turn about the axes of the frame, then a shift
_BLOCK = LENS + PLACE
_ROUNDS = 100
_SETTLED = 1e-10  # relative change of the sum of squares
_UNSETTLED = (
    "the pictures do not settle all unknowns of the cameras: show the target tilted in several "
    "ways and all over the picture, or lower calibrate.radial"
)
_DAMPING = 1e-4, 1e12  # at the start, and where it is given up


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


@dataclass(frozen=True, slots=True, eq=False)
class Adjusted:
    """What the adjustment settles on.

    Attributes
    ----------
    arrangement : Arrangement
    residuals : (M, 2) float64
        Seen minus predicted, px.
    covariance : (C * 16, C * 16) float64
        Of the unknowns of all cameras, 16 for each: fx, fy, cx, cy, k1, k2, k3, p1, p2, skew,
        three small turns about its own axes, translation; zero where held.
    """

    arrangement: Arrangement
    residuals: Floats
    covariance: Floats


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


def free_lens(*, radial: int, tangential: bool, skew: bool) -> Bools:
    """Say which of the ten unknowns of a lens are sought."""
    free = np.zeros(LENS, dtype=np.bool_)
    free[: 4 + radial] = True
    free[7:9] = tangential
    free[9] = skew
    return free


def adjust(
    seen: Observations, start: Arrangement, *, lens: Bools, fixed: int | None, cauchy: float | None
) -> Adjusted:
    """Find the cameras and places that best explain what was seen.

    Parameters
    ----------
    seen : Observations
    start : Arrangement
    lens : (10,) bool
        Which unknowns of each lens are sought, see :func:`free_lens`.
    fixed : int or None
        Camera whose place is held (it is the frame of the world); None if all places of cameras
        are held.
    cauchy : float or None
        Scale in px of residuals that count less; None: all count alike.

    Raises
    ------
    StageError
        If the pictures do not settle the unknowns.

    Notes
    -----
    Levenberg-Marquardt with analytic derivatives. The covariance takes the noise from the
    residuals and supposes that it is the same and independent in all of them.

    References
    ----------
    .. [1] Triggs, B. et al. Bundle adjustment: a modern synthesis (2000).
       :doi:`10.1007/3-540-44480-7_21`
    """
    free = _free(len(start.cameras), lens, fixed)
    at, residuals = start, _residuals(seen, start)
    cost, damping = _cost(residuals, cauchy), _DAMPING[0]
    for _ in range(_ROUNDS):
        system = _normal_equations(seen, at, residuals, cauchy)
        before = cost
        while damping < _DAMPING[1]:
            trial = _moved(at, *system.step(free, damping))
            tried = _residuals(seen, trial)
            if _cost(tried, cauchy) <= cost:
                at, residuals, cost = trial, tried, _cost(tried, cauchy)
                damping = max(damping / 10, 1e-12)
                break
            damping *= 10
        if before - cost <= _SETTLED * before:
            break
    system = _normal_equations(seen, at, residuals, None)
    unknowns = int(free.sum()) + PLACE * len(at.poses)
    noise = float((residuals**2).sum()) / max(2 * len(residuals) - unknowns, 1)
    return Adjusted(at, residuals, noise * system.camera_covariance(free))


def _free(cameras: int, lens: Bools, fixed: int | None) -> Bools:
    free = np.zeros((cameras, _BLOCK), dtype=np.bool_)
    free[:, :LENS] = lens
    if fixed is not None:
        free[np.arange(cameras) != fixed, LENS:] = True
    return free.ravel()


def _cost(residuals: Floats, cauchy: float | None) -> float:
    squares = (residuals**2).sum(axis=1)
    if not np.isfinite(squares).all():
        return float("inf")
    if cauchy is None:
        return float(squares.sum())
    return float(cauchy**2 * np.log1p(squares / cauchy**2).sum())


def _carried(seen: Observations, at: Arrangement) -> tuple[Floats, Floats, Floats]:
    """Points turned by the pose of their view, in the world, and in their camera (M, 3)."""
    turns = np.stack([pose.rotation for pose in at.poses])[seen.view]
    shifts = np.stack([pose.translation for pose in at.poses])[seen.view]
    turned = np.einsum("mij,mj->mi", turns, seen.point)
    world = turned + shifts
    own_turns = np.stack([camera.pose.rotation for camera in at.cameras])[seen.camera]
    own_shifts = np.stack([camera.pose.translation for camera in at.cameras])[seen.camera]
    return turned, world, np.einsum("mij,mj->mi", own_turns, world) + own_shifts


def _residuals(seen: Observations, at: Arrangement) -> Floats:
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


@dataclass(frozen=True, slots=True, eq=False)
class _System:
    """Normal equations in blocks: cameras (C*16), views (V, 6), and what couples them."""

    cameras: Floats
    views: Floats
    coupling: Floats
    camera_side: Floats
    view_side: Floats

    def _scales(self) -> tuple[Floats, Floats]:
        own: Floats = np.sqrt(np.maximum(np.diag(self.cameras), 1e-300))
        places: Floats = np.sqrt(np.maximum(np.einsum("vii->vi", self.views), 1e-300))
        return own, places

    def _reduced(self, damping: float) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Scale, damp, and eliminate the views."""
        own, places = self._scales()
        views = self.views / places[:, :, None] / places[:, None, :]
        views = views + damping * np.eye(PLACE)
        coupling = self.coupling / own[None, :, None] / places[:, None, :]
        inverse = np.asarray(np.linalg.inv(views), dtype=np.float64)
        across: Floats = coupling @ inverse
        cameras = self.cameras / own[:, None] / own[None, :]
        cameras = cameras + damping * np.eye(len(own))
        reduced = cameras - np.einsum("vip,vjp->ij", across, coupling)
        return reduced, across, inverse, own, places

    def step(self, free: Bools, damping: float) -> tuple[Floats, Floats]:
        """Solve for the next step of cameras (C * 16,) and views (V, 6)."""
        reduced, across, inverse, own, places = self._reduced(damping)
        right = self.camera_side / own - np.einsum("vip,vp->i", across, self.view_side / places)
        step = np.zeros(len(own))
        if free.any():
            step[free] = np.linalg.lstsq(reduced[np.ix_(free, free)], right[free])[0]
        coupling = self.coupling / own[None, :, None] / places[:, None, :]
        left = self.view_side / places - np.einsum("vip,i->vp", coupling, step)
        return step / own, np.einsum("vpq,vq->vp", inverse, left) / places

    def camera_covariance(self, free: Bools) -> Floats:
        """Inverse (C * 16, C * 16) of the reduced matrix, for noise of 1 px."""
        try:
            reduced, _, _, own, _ = self._reduced(0.0)
        except np.linalg.LinAlgError as error:
            raise StageError(_UNSETTLED) from error
        covariance = np.zeros_like(reduced)
        if not free.any():
            return covariance
        among = np.ix_(free, free)
        values, vectors = np.linalg.eigh(reduced[among])
        if values[0] <= len(own) * np.finfo(float).eps * values[-1]:
            raise StageError(_UNSETTLED)
        covariance[among] = (vectors / values) @ vectors.T
        scaled: Floats = covariance / own[:, None] / own[None, :]
        return scaled


def _normal_equations(
    seen: Observations, at: Arrangement, residuals: Floats, cauchy: float | None
) -> _System:
    own, places = _slopes(seen, at)
    weights = np.ones(len(residuals))
    if cauchy is not None:
        weights = 1 / (1 + (residuals**2).sum(axis=1) / cauchy**2)
    count, views = len(at.cameras), len(at.poses)
    cameras = np.zeros((count * _BLOCK, count * _BLOCK))
    camera_side = np.zeros(count * _BLOCK)
    place_blocks = np.zeros((views, PLACE, PLACE))
    place_side = np.zeros((views, PLACE))
    coupling = np.zeros((views, count * _BLOCK, PLACE))
    for camera, view, rows in _groups(seen):
        a, b = own[rows].reshape(-1, _BLOCK), places[rows].reshape(-1, PLACE)
        weight = np.repeat(weights[rows], 2)
        wa, wb, r = a * weight[:, None], b * weight[:, None], residuals[rows].ravel()
        block = slice(camera * _BLOCK, (camera + 1) * _BLOCK)
        cameras[block, block] += a.T @ wa
        camera_side[block] += wa.T @ r
        place_blocks[view] += b.T @ wb
        place_side[view] += wb.T @ r
        coupling[view, block] += wa.T @ b
    return _System(cameras, place_blocks, coupling, camera_side, place_side)


def _groups(seen: Observations) -> list[tuple[int, int, slice]]:
    """List the runs of observations of one camera and one view."""
    change = (np.diff(seen.camera) != 0) | (np.diff(seen.view) != 0)
    starts = np.concatenate([[0], np.flatnonzero(change) + 1, [len(seen.camera)]])
    return [
        (int(seen.camera[low]), int(seen.view[low]), slice(low, high))
        for low, high in pairwise(starts)
    ]


def _slopes(seen: Observations, at: Arrangement) -> tuple[Floats, Floats]:
    """Differentiate the pixel by the unknowns of camera (M, 2, 16) and view (M, 2, 6).

    The shift of a dot's middle is taken as constant here; it changes a thousand times less.
    """
    turned, _, own = _carried(seen, at)
    flat = own[:, :2] / own[:, 2:]
    by_camera = np.zeros((len(flat), 2, _BLOCK))
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


def _moved(at: Arrangement, own: Floats, places: Floats) -> Arrangement:
    cameras = tuple(
        _moved_camera(camera, step)
        for camera, step in zip(at.cameras, own.reshape(-1, _BLOCK), strict=True)
    )
    poses = tuple(_moved_pose(pose, step) for pose, step in zip(at.poses, places, strict=True))
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
        pose=_moved_pose(camera.pose, step[LENS:]),
    )


def _moved_pose(pose: RigidTransform, step: Floats) -> RigidTransform:
    turn = Rotation.from_rotvec(step[:3]).as_matrix()
    return RigidTransform(turn @ pose.rotation, pose.translation + step[3:])
