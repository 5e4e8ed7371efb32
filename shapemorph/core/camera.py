"""Cameras with lens distortion, and rigs of several of them.

A pixel comes about in four steps, as in OpenCV: X_c = R X + T carries a point into the frame of
the camera (x right, y down, z forward); (x, y) = (X_c, Y_c) / Z_c; the lens moves that to

    x' = x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²)
    y' = y (1 + k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2 y²) + 2 p2 x y,   r² = x² + y²

and the sensor reads u = fx x' + s y' + cx, v = fy y' + cy. Pixel centres are at integers.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.errors import DataError
from shapemorph.core.transform import RigidTransform

_ROUNDS = 60  # Newton steps after which a pixel counts as outside the lens model
_CLOSE = 1e-13  # of the focal length


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """A pinhole with a lens.

    Attributes
    ----------
    size : (int, int)
        Width and height of the picture, px.
    focal : (2,) float64
        fx, fy in px.
    centre : (2,) float64
        Principal point (cx, cy) in px.
    radial : (3,) float64
        k1, k2, k3.
    tangential : (2,) float64
        p1, p2.
    skew : float
        s in px.
    pose : RigidTransform
        camera_from_world, mm.
    """

    size: tuple[int, int]
    focal: Floats
    centre: Floats
    radial: Floats = field(default_factory=lambda: np.zeros(3))
    tangential: Floats = field(default_factory=lambda: np.zeros(2))
    skew: float = 0.0
    pose: RigidTransform = field(default_factory=RigidTransform.identity)

    def __post_init__(self) -> None:
        for name, length in (("focal", 2), ("centre", 2), ("radial", 3), ("tangential", 2)):
            value = getattr(self, name)
            if value.shape != (length,) or not np.isfinite(value).all():
                raise DataError(f"{name} of a camera must be {length} finite numbers, got {value}")
        if not (self.focal > 0).all():
            raise DataError(f"the focal length of a camera must be positive, got {self.focal} px")
        if min(self.size) < 1:
            raise DataError(f"a camera needs a picture of at least 1 x 1 px, got {self.size}")

    @property
    def matrix(self) -> Floats:
        """K (3, 3), px."""
        (fx, fy), (cx, cy) = self.focal, self.centre
        return np.array([[fx, self.skew, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])

    @property
    def position(self) -> Floats:
        """Centre of projection (3,) in the world, mm."""
        return -self.pose.rotation.T @ self.pose.translation

    def placed(self, pose: RigidTransform) -> "Camera":
        """Return the same camera elsewhere."""
        return replace(self, pose=pose)

    def project(self, points: Floats) -> Floats:
        """Pixels (..., 2) at which world points (..., 3) in mm are seen; NaN behind the camera."""
        own = self.pose.apply(points)
        depth = np.where(own[..., 2:] > 0, own[..., 2:], np.nan)
        return self.pixels_of(distort(own[..., :2] / depth, self.radial, self.tangential))

    def pixels_of(self, bent: Floats) -> Floats:
        """Pixels (..., 2) of points (..., 2) on the unit plane behind the lens."""
        slanted = np.stack(
            [np.full(bent.shape[:-1], self.skew), np.zeros(bent.shape[:-1])], axis=-1
        )
        return bent * self.focal + slanted * bent[..., 1:] + self.centre

    def normalised(self, pixels: Floats) -> Floats:
        """Directions (x, y) with z = 1 (..., 2), freed of distortion, of pixels (..., 2).

        A pixel that no direction leads to is NaN.
        """
        y = (pixels[..., 1] - self.centre[1]) / self.focal[1]
        x = (pixels[..., 0] - self.centre[0] - self.skew * y) / self.focal[0]
        return undistort(np.stack([x, y], axis=-1), self.radial, self.tangential)

    def rays(self, pixels: Floats) -> Floats:
        """Give the unit directions (..., 3) in the world along which pixels (..., 2) look."""
        flat = self.normalised(pixels)
        ahead = np.concatenate([flat, np.ones((*flat.shape[:-1], 1))], axis=-1)
        own = ahead / np.linalg.norm(ahead, axis=-1, keepdims=True)
        seen: Floats = own @ self.pose.rotation
        return seen


@dataclass(frozen=True, slots=True, eq=False)
class Rig:
    """Cameras in one world.

    Attributes
    ----------
    cameras : tuple of Camera
        The world is the frame of the first one unless poses say otherwise.
    names : tuple of str
        One for each camera.
    """

    cameras: tuple[Camera, ...]
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        if not self.cameras or len(self.cameras) != len(self.names):
            raise DataError(
                f"a rig needs a name for each of at least one camera, got {len(self.cameras)} "
                f"cameras and {len(self.names)} names"
            )
        if len(set(self.names)) < len(self.names):
            raise DataError(f"the cameras of a rig need different names, got {self.names}")

    def between(self, first: int, second: int) -> RigidTransform:
        """second_from_first: X2 = R X1 + T for points in the frames of two cameras."""
        one, two = self.cameras[first].pose, self.cameras[second].pose
        rotation = two.rotation @ one.rotation.T
        return RigidTransform(rotation, two.translation - rotation @ one.translation)

    def baseline(self, first: int, second: int) -> float:
        """Distance between the centres of projection of two cameras, mm."""
        gap = self.cameras[second].position - self.cameras[first].position
        return float(np.linalg.norm(gap))

    def stereo_angle(self, first: int, second: int) -> float:
        """Angle between the optical axes of two cameras, radians."""
        axes = self.cameras[first].pose.rotation[2], self.cameras[second].pose.rotation[2]
        return float(np.arctan2(np.linalg.norm(np.cross(*axes)), np.dot(*axes)))


def distort(flat: Floats, radial: Floats, tangential: Floats) -> Floats:
    """Move points (..., 2) of the unit plane as the lens does."""
    x, y = flat[..., 0], flat[..., 1]
    square = x * x + y * y
    growth = 1 + square * (radial[0] + square * (radial[1] + square * radial[2]))
    p1, p2 = tangential
    return np.stack(
        [
            x * growth + 2 * p1 * x * y + p2 * (square + 2 * x * x),
            y * growth + p1 * (square + 2 * y * y) + 2 * p2 * x * y,
        ],
        axis=-1,
    )


def distortion_slope(flat: Floats, radial: Floats, tangential: Floats) -> Floats:
    """Give the derivative (..., 2, 2) of the distorted by the undistorted position."""
    x, y = flat[..., 0], flat[..., 1]
    square = x * x + y * y
    growth = 1 + square * (radial[0] + square * (radial[1] + square * radial[2]))
    steep = 2 * (radial[0] + square * (2 * radial[1] + square * 3 * radial[2]))
    p1, p2 = tangential
    across = steep * x * y + 2 * p1 * x + 2 * p2 * y
    return np.stack(
        [
            np.stack([growth + steep * x * x + 2 * p1 * y + 6 * p2 * x, across], axis=-1),
            np.stack([across, growth + steep * y * y + 6 * p1 * y + 2 * p2 * x], axis=-1),
        ],
        axis=-2,
    )


def undistort(bent: Floats, radial: Floats, tangential: Floats) -> Floats:
    """Find the points (..., 2) that the lens moves to the given ones, by Newton's method.

    Of several that it would move there, the one on the branch that starts at the axis; NaN
    where there is none.
    """
    if not radial.any() and not tangential.any():
        return bent.copy()
    flat = bent.copy()
    for _ in range(_ROUNDS):
        missing = bent - distort(flat, radial, tangential)
        if np.nanmax(np.abs(missing), initial=0.0) < _CLOSE:
            break
        slope = distortion_slope(flat, radial, tangential)
        step = _solved(slope, missing)
        length = np.linalg.norm(step, axis=-1, keepdims=True)
        flat = flat + step * np.minimum(1.0, 0.3 / np.maximum(length, 1e-300))
    found = np.abs(bent - distort(flat, radial, tangential)).max(axis=-1) < 1e3 * _CLOSE
    return np.where((found & _near_branch(flat, radial, tangential))[..., None], flat, np.nan)


def _solved(slope: Floats, right: Floats) -> Floats:
    (a, b), (c, d) = _entries(slope)
    volume = a * d - b * c
    volume = np.where(np.abs(volume) > 1e-12, volume, np.nan)
    first, second = right[..., 0], right[..., 1]
    return np.stack([(d * first - b * second) / volume, (a * second - c * first) / volume], axis=-1)


def _entries(slope: Floats) -> tuple[Floats, Floats]:
    first, second = (np.moveaxis(slope[..., row, :], -1, 0) for row in range(2))
    return first, second


def _near_branch(flat: Floats, radial: Floats, tangential: Floats) -> Bools:
    """Say where the map keeps its orientation all the way out from the axis."""
    kept = np.ones(flat.shape[:-1], dtype=np.bool_)
    for share in (0.25, 0.5, 0.75, 1.0):
        (a, b), (c, d) = _entries(distortion_slope(share * flat, radial, tangential))
        kept &= a * d - b * c > 0
    return kept
