"""What many photographs say about the grey of a surface."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.camera import Camera
from shapemorph.core.image import GreyImage

_SATURATED = 0.90, 0.98  # grey from which a pixel counts less, and from which not at all
_LEAST_COSINE = 0.35  # views more slanted than that do not count
_STEEP = 2  # power of the cosine that views are weighed by


@dataclass(frozen=True, slots=True, eq=False)
class Photograph:
    """A picture and the camera that took it, placed in the frame of the part."""

    camera: Camera
    picture: GreyImage


def average_grey(
    points: Floats, normals: Floats, photographs: Sequence[Photograph]
) -> tuple[Floats, Floats]:
    """Average what all photographs show at points of a surface.

    Views count the more, the more directly they look at the surface; near-white pixels count
    less or not at all, so that glare disappears where another light or view has none. Parts
    that hide each other are not known of: the surface must be seen freely by every camera
    that faces it.

    Parameters
    ----------
    points, normals : (N, 3)
        mm; unit normals, outward.
    photographs : sequence of Photograph

    Returns
    -------
    grey : (N,)
        NaN where no photograph shows the point.
    weight : (N,)
        Sum of the weights.

    References
    ----------
    .. [1] Genovese, K.; Sorgente, D. (2017). Opt. Lasers Eng.
       :doi:`10.1016/j.optlaseng.2017.06.020`
    """
    total, weights = np.zeros(len(points)), np.zeros(len(points))
    fallback, seen = np.zeros(len(points)), np.zeros(len(points))
    for photograph in photographs:
        grey, cosine = _looked_up(points, normals, photograph)
        facing = np.where(cosine > _LEAST_COSINE, cosine, 0.0) ** _STEEP
        facing = np.where(np.isfinite(grey), facing, 0.0)
        value = np.where(facing > 0, grey, 0.0)
        low, high = _SATURATED
        weight = facing * np.clip((high - value) / (high - low), 0.0, 1.0)
        total += weight * value
        weights += weight
        fallback += facing * value
        seen += facing
    with np.errstate(invalid="ignore", divide="ignore"):
        glaring = np.where(seen > 0, fallback / seen, np.nan)
        return np.where(weights > 0, total / weights, glaring), weights


def _looked_up(points: Floats, normals: Floats, photograph: Photograph) -> tuple[Floats, Floats]:
    """Grey (N,) at points, NaN outside the picture, and the cosine of the angle of view."""
    from scipy.ndimage import map_coordinates

    camera, picture = photograph.camera, photograph.picture
    pixels = camera.project(points)
    height, width = picture.shape
    inside = np.isfinite(pixels).all(axis=1)
    x, y = np.where(inside, pixels.T, 0.0)
    inside &= (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)
    nearest = np.rint(y).astype(int).clip(0, height - 1), np.rint(x).astype(int).clip(0, width - 1)
    inside &= picture.mask[nearest]
    grey = np.full(len(points), np.nan)
    grey[inside] = map_coordinates(
        picture.grey.astype(np.float64), [y[inside], x[inside]], order=3, mode="nearest"
    )
    away = camera.position - points
    cosine = (away * normals).sum(axis=1) / np.linalg.norm(away, axis=1)
    return grey, cosine
