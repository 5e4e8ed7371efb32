"""Many views of one part: which to match with which, and one cloud of points from all."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.camera import Camera
from shapemorph.core.reconstruction import Reconstruction
from shapemorph.core.status import PointStatus
from shapemorph.methods.quadratic_fit import quadratic_operators, quadratics

_APART = 0.7  # of the spacing: nearer points of another patch are the same place
_NEAR = 2.2  # of the spacing: points that make one surface
_MOST = 160  # such points
_ROUNDS, _ODD = 6, 2.5  # fits; times the usual distance from one at which a point is left out
_CHUNK = 4000  # points whose surfaces are fitted at a time
_OFF = 0.4  # of the angle that is asked for: how much a pair may differ from it


@dataclass(frozen=True, slots=True, eq=False)
class Merged:
    """One cloud from overlapping patches.

    Attributes
    ----------
    points : (N, 3) float64
        About one spacing apart, mm.
    towards : (N, 3) float64
        Unit vectors to the camera that saw each.
    overlap_rms : float
        Distance of points of one patch from the surface of those before it, rms, mm; NaN
        where nothing overlaps.
    """

    points: Floats
    towards: Floats
    overlap_rms: float


def pair_up(
    cameras: Sequence[Camera], *, angle: float, patches: int | None
) -> list[tuple[int, int]]:
    """Choose which views to match: neighbours whose axes are about an angle apart.

    Parameters
    ----------
    cameras : sequence of Camera
        In the order in which they were taken.
    angle : float
        Between the axes of a pair, radians.
    patches : int or None
        How many pairs, evenly among all that are possible; None: all of them.
    """
    axes = np.stack([camera.pose.rotation[2] for camera in cameras])
    apart = np.arccos(np.clip(axes @ axes.T, -1.0, 1.0))
    pairs = []
    for first in range(len(cameras)):
        later = (first + np.arange(1, len(cameras) // 2 + 1)) % len(cameras)
        best = int(later[np.argmin(np.abs(apart[first, later] - angle))])
        fits = abs(apart[first, best] - angle) <= _OFF * angle
        if fits and (best, first) not in pairs:
            pairs.append((first, best))
    if patches is None or patches >= len(pairs):
        return pairs
    chosen = np.unique(np.round(np.linspace(0, len(pairs) - 1, patches)).astype(int))
    return [pairs[k] for k in chosen]


def merge(patches: Sequence[Reconstruction]) -> Merged:
    """Put the points of all patches into one cloud.

    The first patch keeps its points; each further one adds those that lie where there is none
    yet. Then every point moves, along the surface normal, onto the quadratic through all
    points of all patches about it; points that few agree with, as glare makes them, do not
    count.
    """
    clouds = [patch.points[patch.status == PointStatus.OK] for patch in patches]
    spacing = _spacing(patches[0])
    kept, towards = clouds[0], _towards(patches[0], clouds[0])
    gaps: list[Floats] = []
    for patch, cloud in zip(patches[1:], clouds[1:], strict=True):
        distance, _ = cKDTree(kept).query(cloud)
        new: Bools = np.asarray(distance) > _APART * spacing
        gaps.append(_heights(cloud[~new], kept, spacing))
        kept = np.concatenate([kept, cloud[new]])
        towards = np.concatenate([towards, _towards(patch, cloud[new])])
    settled = kept - _along(kept, np.concatenate(clouds), spacing)
    height = np.concatenate(gaps) if gaps else np.zeros(0)
    height = height[np.isfinite(height)]
    rms = float(np.sqrt((height**2).mean())) if len(height) else float("nan")
    return Merged(settled, towards, rms)


def _spacing(patch: Reconstruction) -> float:
    """Median distance of neighbours of the grid, mm."""
    steps = np.linalg.norm(np.diff(patch.points, axis=1), axis=-1)
    return float(np.nanmedian(steps))


def _towards(patch: Reconstruction, points: Floats) -> Floats:
    away = patch.rig.cameras[0].position - points
    towards: Floats = away / np.linalg.norm(away, axis=1, keepdims=True)
    return towards


def _heights(points: Floats, cloud: Floats, spacing: float) -> Floats:
    """Distances (N,) of points from the surface of a cloud, mm; NaN where it has none."""
    return _from_surface(points, cloud, spacing)[0]


def _along(points: Floats, cloud: Floats, spacing: float) -> Floats:
    """Vectors (N, 3) from the surface of a cloud to points; zero where it has none."""
    height, normal = _from_surface(points, cloud, spacing)
    return np.where(np.isfinite(height), height, 0.0)[:, None] * normal


def _from_surface(points: Floats, cloud: Floats, spacing: float) -> tuple[Floats, Floats]:
    """Heights (N,) over quadratics through the cloud about each point, and normals (N, 3)."""
    height, normal = np.zeros(len(points)), np.zeros((len(points), 3))
    tree = cKDTree(cloud)
    for start in range(0, len(points), _CHUNK):
        part = slice(start, start + _CHUNK)
        height[part], normal[part] = _over_quadratics(points[part], cloud, tree, spacing)
    return height, normal


def _over_quadratics(
    points: Floats, cloud: Floats, tree: "cKDTree", spacing: float
) -> tuple[Floats, Floats]:
    """Fit about each point what most of the cloud agrees to; see :func:`_from_surface`."""
    most = min(_MOST, len(cloud))
    distance, number = (
        np.asarray(part).reshape(len(points), most)
        for part in tree.query(points, k=most, distance_upper_bound=_NEAR * spacing)
    )
    near = np.isfinite(distance)
    about = np.where(near[..., None], cloud[np.where(near, number, 0)] - points[:, None], 0.0)
    count = np.maximum(near.sum(axis=1), 1)[:, None]
    spread = about - near[..., None] * (about.sum(axis=1) / count)[:, None]
    axes: Floats = np.linalg.eigh(np.swapaxes(spread, 1, 2) @ spread)[1]
    own = about @ axes
    terms, kept = quadratics(own[..., 1:]), near
    for _ in range(_ROUNDS):
        operators = quadratic_operators(own[..., 1:], kept)
        fitted = (operators @ own[..., :1])[..., 0]
        off = np.abs(own[..., 0] - (terms @ fitted[..., None])[..., 0])
        usual = 1.4826 * _middle(np.where(near, off, np.nan))
        kept = near & (off <= _ODD * usual[:, None])
    return -fitted[:, 0], axes[..., 0]


def _middle(values: Floats) -> Floats:
    """Medians (N,) of rows without NaN; infinite for rows that hold nothing."""
    count = np.isfinite(values).sum(axis=1)
    ordered = np.sort(values, axis=1)
    middle: Floats = np.take_along_axis(ordered, (np.maximum(count, 1) // 2)[:, None], axis=1)[:, 0]
    return np.where(np.isfinite(middle), middle, np.inf)
