"""Where a texture lies on a flattened picture as one even sheet, and how it slopes there."""

import numpy as np

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.kernels.blend import blend_corners
from shapemorph.kernels.raster import Triangles

REACH = 2  # px around a pixel that are looked at
UNEVEN = 0.05  # px; rms by which the texture may stray from a plane
NOWHERE = np.zeros((0, 0, 2, 2), np.float32)


def even_slopes(
    triangle: Triangles, barycentric: Floats, corner_values: Floats, textures: Ints
) -> Greys:
    """Fit a plane to the texel positions around each pixel.

    Where the plane holds, the texture under a pixel can be read without asking which
    triangle each sample of it meets: a seam, a fold or the rim would show.

    Parameters
    ----------
    triangle : (H, W) int32
        Triangle under each pixel centre, -1 where there is none.
    barycentric : (H, W, 2)
        Weights of its second and third corner.
    corner_values : (M, 3, 2)
        Texel position (x, y) of every corner.
    textures : (M,)
        Texture of each triangle.

    Returns
    -------
    (H, W, 2, 2) float32
        d texel / d px; NaN where the texture is not even within 2 px.
    """
    texels = _texels(triangle, barycentric, corner_values, textures)
    place = np.arange(-REACH, REACH + 1, dtype=np.float64)
    even, tilt = np.full(len(place), 1.0 / len(place)), place / (place @ place)
    variance = float(place @ place) / len(place)
    slopes = np.empty((*triangle.shape, 2, 2), np.float32)
    strayed = np.zeros(triangle.shape)
    for axis, values in enumerate(texels):
        mean = _filtered(values, even, even)
        along_x, along_y = _filtered(values, tilt, even), _filtered(values, even, tilt)
        strayed += _filtered(values**2, even, even) - mean**2
        strayed -= variance * (along_x**2 + along_y**2)
        slopes[..., axis, 0], slopes[..., axis, 1] = along_x, along_y
    texels_per_px = 0.5 * (slopes.astype(np.float64) ** 2).sum(axis=(-1, -2))
    slopes[~(strayed <= UNEVEN**2 * texels_per_px)] = np.nan
    return slopes


def _texels(
    triangle: Triangles, barycentric: Floats, corner_values: Floats, textures: Ints
) -> list[Floats]:
    """Texel positions x and y (H, W) of the pixels; textures lie far from each other."""
    pairs = blend_corners(corner_values, triangle.ravel(), barycentric.reshape(-1, 2))
    found = pairs.reshape(*triangle.shape, 2)
    if (textures != textures[0]).any():
        away = 2.0 * max(float(np.abs(corner_values).max()), 1.0)
        found[..., 0] += textures[triangle] * away
    return [np.pad(found[..., axis], REACH, constant_values=np.nan) for axis in (0, 1)]


def _filtered(values: Floats, along_x: Floats, along_y: Floats) -> Floats:
    """Weigh the pixels around each one, the rim of the picture left out."""
    import cv2

    whole = cv2.sepFilter2D(values, cv2.CV_64F, along_x, along_y)
    return np.asarray(whole[REACH:-REACH, REACH:-REACH])
