"""Points in space from where two or more cameras see them."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.camera import Camera, distortion_slope

_ROUNDS = 4  # Newton steps from the midpoint; each squares the error


@dataclass(frozen=True, slots=True, eq=False)
class Triangulated:
    """Points in space and how well their pictures agree.

    Attributes
    ----------
    points : (N, 3) float64
        In the world, mm; NaN where not seen.
    epipolar_error : (N,) float64
        Distance in px of what was seen from what a point in space can be seen as: root mean
        square over the cameras.
    sigma : (N, 3) float64
        Random part of the standard deviation of x, y, z, mm.
    """

    points: Floats
    epipolar_error: Floats
    sigma: Floats


def triangulate(cameras: tuple[Camera, ...], pixels: Floats, sigma_px: Floats) -> Triangulated:
    """Find the points whose pictures, lens included, lie nearest to what was seen.

    Parameters
    ----------
    cameras : tuple of Camera
        Two or more.
    pixels : (C, N, 2)
        What each camera saw.
    sigma_px : (C, N, 2)
        Standard deviations of that; they weigh the cameras.

    References
    ----------
    .. [1] Hartley, R.; Sturm, P. (1997). Comput. Vis. Image Underst. 68, 146-157.
       :doi:`10.1006/cviu.1997.0547`
    """
    points = _midpoints(cameras, pixels)
    weights = 1.0 / np.maximum(sigma_px, 1e-6)
    for _ in range(_ROUNDS):
        points = points + _step(cameras, points, pixels, weights)[0]
    _, covariance = _step(cameras, points, pixels, weights)
    rest = np.stack([camera.project(points) for camera in cameras]) - pixels
    error = np.sqrt((rest**2).sum(axis=-1).mean(axis=0))
    return Triangulated(points, error, np.sqrt(np.einsum("nii->ni", covariance)))


def _midpoints(cameras: tuple[Camera, ...], pixels: Floats) -> Floats:
    """Points nearest to all rays, least squares."""
    normal = np.zeros((pixels.shape[1], 3, 3))
    right = np.zeros((pixels.shape[1], 3))
    for camera, seen in zip(cameras, pixels, strict=True):
        ray = camera.rays(seen)
        across = np.eye(3) - ray[:, :, None] * ray[:, None, :]
        normal += across
        right += across @ camera.position
    return _solve(normal, right)


def _step(
    cameras: tuple[Camera, ...], points: Floats, pixels: Floats, weights: Floats
) -> tuple[Floats, Floats]:
    """Gauss-Newton step (N, 3), and the covariance (N, 3, 3) there."""
    normal = np.zeros((len(points), 3, 3))
    right = np.zeros((len(points), 3))
    for camera, seen, weight in zip(cameras, pixels, weights, strict=True):
        slope = pixel_slopes(camera, points) * weight[:, :, None]
        rest = (seen - camera.project(points)) * weight
        normal += np.swapaxes(slope, 1, 2) @ slope
        right += np.einsum("nij,ni->nj", slope, rest)
    lost = np.asarray(~np.isfinite(normal).all(axis=(1, 2)))
    normal[lost] = np.eye(3)
    covariance: Floats = np.asarray(np.linalg.inv(normal), dtype=np.float64)
    covariance[lost] = np.nan
    return np.einsum("nij,nj->ni", covariance, right), covariance


def pixel_slopes(camera: Camera, points: Floats) -> Floats:
    """Differentiate (N, 2, 3) the pixel by the point (N, 3) in the world."""
    own = camera.pose.apply(points)
    depth = own[:, 2:]
    flat = own[:, :2] / depth
    pinhole = np.zeros((len(points), 2, 3))
    pinhole[:, 0, 0] = pinhole[:, 1, 1] = 1 / depth[:, 0]
    pinhole[:, :, 2] = -flat / depth
    lens = camera.matrix[:2, :2] @ distortion_slope(flat, camera.radial, camera.tangential)
    slopes: Floats = lens @ pinhole @ camera.pose.rotation
    return slopes


def _solve(matrix: Floats, right: Floats) -> Floats:
    lost = np.asarray(~np.isfinite(matrix).all(axis=(1, 2)))
    safe = np.where(lost[:, None, None], np.eye(3), matrix)
    found: Floats = np.asarray(np.linalg.solve(safe, right[..., None])[..., 0], dtype=np.float64)
    found[lost] = np.nan
    return found
