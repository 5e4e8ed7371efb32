"""How good a calibration is: what residuals, coverage and control points say."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.calibration import Calibration, Sighting, Target
from shapemorph.core.camera import Camera, Rig, distort
from shapemorph.methods.cameras.bundle_model import LENS, PLACE
from shapemorph.methods.cameras.dot_bias import middle_of_dots
from shapemorph.methods.cameras.triangulation import triangulate
from shapemorph.methods.rigid import fit_rigid

CELLS = 8  # across the shorter side of a picture
_LEAST_IN_CELL = 4


@dataclass(frozen=True, slots=True, eq=False)
class ResidualPattern:
    """Residuals of one camera, averaged over cells of its picture.

    Attributes
    ----------
    centres : (K, 2) float64
        Middles of the cells with points, px.
    means : (K, 2) float64
        Mean residual there, px.
    counts : (K,) int64
    coverage : float
        Share of the cells with points.
    systematic_px : float
        Root mean square of the means beyond what noise alone makes of them.
    """

    centres: Floats
    means: Floats
    counts: Ints
    coverage: float
    systematic_px: float


@dataclass(frozen=True, slots=True, eq=False)
class ControlPoints:
    """Known points of a target against where the cameras see them in space.

    Attributes
    ----------
    target : str
    points : int
    mean_mm, rms_mm, max_mm : float
        Distances after the rigid motion of each view is taken out.
    """

    target: str
    points: int
    mean_mm: float
    rms_mm: float
    max_mm: float


@dataclass(frozen=True, slots=True, eq=False)
class Drift:
    """What changed between two calibrations of one rig.

    Attributes
    ----------
    epipolar_px : float
        Root mean square distance of points, as seen now, from where the earlier calibration
        would have one camera see what the other sees.
    shape_mm : float
        Root mean square change of the shape that both give, rigid motion taken out.
    scale : float
        Change of size, as a share.
    """

    epipolar_px: float
    shape_mm: float
    scale: float


def residual_pattern(calibration: Calibration, camera: int) -> ResidualPattern:
    """Average the residuals of one camera over cells of its picture."""
    width, height = calibration.rig.cameras[camera].size
    size = min(width, height) / CELLS
    across, down = int(np.ceil(width / size)), int(np.ceil(height / size))
    pairs = zip(calibration.sightings, calibration.residuals, strict=True)
    mine = [(seen.pixels, rest) for seen, rest in pairs if seen.camera == camera]
    pixels = np.concatenate([pair[0] for pair in mine])
    rest = np.concatenate([pair[1] for pair in mine])
    column, row = np.clip((pixels / size).astype(np.int64), 0, [across - 1, down - 1]).T
    cell = row * across + column
    counts = np.bincount(cell, minlength=across * down)
    sums = np.stack([np.bincount(cell, rest[:, k], across * down) for k in (0, 1)], axis=-1)
    used = np.flatnonzero(counts >= _LEAST_IN_CELL)
    means: Floats = np.asarray(sums[used] / counts[used, None], dtype=np.float64)
    cells = np.stack([used % across, used // across], axis=-1).astype(np.float64)
    centres = (cells + 0.5) * size
    chance = (rest**2).sum(axis=1).mean() / counts[used]
    beyond = (means**2).sum(axis=1) - chance
    systematic = float(np.sqrt(max(beyond.mean(), 0.0))) if len(used) else 0.0
    return ResidualPattern(
        centres, means, counts[used].astype(np.int64), float((counts > 0).mean()), systematic
    )


def baseline_sigma(calibration: Calibration, camera: int) -> float:
    """Give the standard deviation of the distance of a camera from the first one, mm."""
    pose = calibration.rig.cameras[camera].pose
    block = slice(camera * (LENS + PLACE) + LENS + 3, (camera + 1) * (LENS + PLACE))
    covariance = calibration.covariance[block, block]
    along = pose.translation / np.linalg.norm(pose.translation)
    return float(np.sqrt(along @ covariance @ along))


def control_points(calibration: Calibration) -> list[ControlPoints]:
    """Compare the known points of each target with where two cameras see them in space."""
    errors: dict[str, list[Floats]] = {}
    for number, view in enumerate(calibration.views):
        seen = [one for one in calibration.sightings if one.view == number]
        if len(seen) > 1:
            errors.setdefault(view.target.name, []).append(
                _view_errors(calibration, seen, view.target)
            )
    return [
        ControlPoints(
            name,
            len(found),
            float(found.mean()),
            float(np.sqrt((found**2).mean())),
            float(found.max()),
        )
        for name, found in ((name, np.concatenate(parts)) for name, parts in errors.items())
        if len(found)
    ]


def _view_errors(calibration: Calibration, seen: list[Sighting], target: Target) -> Floats:
    ids, pixels = _seen_by_two(calibration, seen[0], seen[1], target)
    if len(ids) < 4:
        return np.zeros(0)
    cameras = tuple(calibration.rig.cameras[one.camera] for one in seen[:2])
    points = triangulate(cameras, pixels, np.ones(pixels.shape)).points
    known = target.points[ids]
    errors = fit_rigid(points, known, np.ones(len(ids))).apply(points) - known
    lengths: Floats = np.linalg.norm(errors, axis=1)
    return lengths


def _seen_by_two(
    calibration: Calibration, one: Sighting, other: Sighting, target: Target
) -> tuple[Ints, Floats]:
    """Points that both saw, and where (2, N, 2) the middles themselves are seen, px."""
    ids, first, second = np.intersect1d(one.ids, other.ids, return_indices=True)
    pixels = []
    for seen, numbers in ((one, first), (other, second)):
        camera = calibration.rig.cameras[seen.camera]
        pixel = seen.pixels[numbers]
        if target.dot_radius > 0:
            place = calibration.poses[seen.view]
            own = camera.pose.apply(place.apply(target.points[ids]))
            up = np.array([[0.0, 0.0, 1.0]])
            normals = up if target.normals is None else target.normals[ids]
            turned = camera.pose.rotate(place.rotate(normals)) + np.zeros_like(own)
            middle = middle_of_dots(own, turned, np.full(len(ids), target.dot_radius))
            pixel = pixel - (_seen_at(camera, middle) - _seen_at(camera, own[:, :2] / own[:, 2:]))
        pixels.append(pixel)
    return ids.astype(np.int64), np.stack(pixels)


def _seen_at(camera: Camera, flat: Floats) -> Floats:
    return camera.pixels_of(distort(flat, camera.radial, camera.tangential))


def drift_since(calibration: Calibration, before: Rig) -> Drift | None:
    """Say what an earlier calibration makes of the points that two cameras see now.

    None where no two cameras saw one view, or the rigs have other cameras.
    """
    if len(before.cameras) != len(calibration.rig.cameras):
        return None
    now: list[Floats] = []
    then: list[Floats] = []
    errors: list[Floats] = []
    for number, view in enumerate(calibration.views):
        seen = [one for one in calibration.sightings if one.view == number]
        if len(seen) < 2:
            continue
        _, pixels = _seen_by_two(calibration, seen[0], seen[1], view.target)
        both = tuple(one.camera for one in seen[:2])
        for rig, points in ((calibration.rig, now), (before, then)):
            cameras = tuple(rig.cameras[camera] for camera in both)
            found = triangulate(cameras, pixels, np.ones(pixels.shape))
            points.append(found.points)
        errors.append(found.epipolar_error)
    if not now:
        return None
    return _drift(np.concatenate(now), np.concatenate(then), np.concatenate(errors))


def _drift(now: Floats, then: Floats, error: Floats) -> Drift:
    known = np.isfinite(now).all(axis=1) & np.isfinite(then).all(axis=1)
    now, then = now[known], then[known]
    motion = fit_rigid(then, now, np.ones(len(now)))
    change = motion.apply(then) - now
    sizes = [np.linalg.norm(points - points.mean(axis=0)) for points in (now, then)]
    return Drift(
        float(np.sqrt(np.nanmean(error**2))),
        float(np.sqrt((change**2).sum(axis=1).mean())),
        float(sizes[0] / sizes[1] - 1),
    )
