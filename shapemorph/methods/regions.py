"""The part of a picture that a user wants measured."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.errors import ConfigError
from shapemorph.core.image import CalibratedImage
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.region import Region
from shapemorph.methods.surface_lookup import pixel_positions


def region_mask(region: Region | None, mesh: TexturedMesh, image: CalibratedImage) -> Bools:
    """Mark the pixels of the surface that lie in a region.

    Parameters
    ----------
    region : Region or None
        None is the whole surface.
    mesh : TexturedMesh
    image : CalibratedImage
        Of that mesh.

    Returns
    -------
    (H, W)

    Raises
    ------
    ConfigError
        If a mask picture has another size than the image, or nothing is left.
    """
    mask = image.image.mask.copy()
    if region is None:
        return mask
    mask &= picture_region(region, image.image.shape, picture="flattened reference image")
    if region.centre is not None and region.radius is not None:
        with np.errstate(invalid="ignore"):
            distance = np.linalg.norm(pixel_positions(mesh, image) - region.centre, axis=2)
            mask &= distance <= region.radius
    if not mask.any():
        raise ConfigError(
            f"the region holds no pixel of {mesh.name}: check its polygon (px of the flattened "
            "reference image), mask or ball (units and frame of the file)"
        )
    return mask


def picture_region(region: Region, shape: tuple[int, int], *, picture: str) -> Bools:
    """Mark the pixels that the mask and the polygons of a region allow.

    Parameters
    ----------
    region : Region
    shape : (int, int)
        Height and width.
    picture : str
        What messages call it.

    Returns
    -------
    (H, W)

    Raises
    ------
    ConfigError
        If the mask has another size.
    """
    allowed = np.ones(shape, dtype=bool)
    if region.mask is not None:
        if region.mask.shape != shape:
            rows, cols = region.mask.shape
            raise ConfigError(
                f"region mask: expected a picture of {shape[1]} x {shape[0]} px, the size of the "
                f"{picture}, got {cols} x {rows}: draw it on that image"
            )
        allowed &= region.mask
    if region.polygons is not None:
        allowed &= _fill_any(region.polygons, shape)
    return allowed & ~_fill_any(region.holes, shape)


def _fill_any(polygons: tuple[Floats, ...], shape: tuple[int, int]) -> Bools:
    filled = np.zeros(shape, dtype=bool)
    for corners in polygons:
        filled |= fill_polygon(corners, shape)
    return filled


def fill_polygon(corners: Floats, shape: tuple[int, int]) -> Bools:
    """Mark the pixel centres inside a polygon (even-odd rule).

    Each edge toggles everything to its right in the rows that it crosses.

    Parameters
    ----------
    corners : (K, 2)
        (x, y) in px, pixel centres at integers.
    shape : (int, int)
        Height and width.
    """
    height, width = shape
    toggles = np.zeros((height, width + 1), dtype=bool)
    rows = np.arange(height)
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        crossed = rows[(y0 <= rows) != (y1 <= rows)]
        if len(crossed):
            x = x0 + (crossed - y0) / (y1 - y0) * (x1 - x0)
            toggles[crossed, np.clip(np.ceil(x), 0, width).astype(int)] ^= True
    return np.logical_xor.accumulate(toggles, axis=1)[:, :width]
