"""The part of a calibrated image that a user wants measured."""

import numpy as np

from shapemorph.core.arrays import Bools
from shapemorph.core.errors import ConfigError
from shapemorph.core.image import CalibratedImage
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.region import Region
from shapemorph.kernels.raster import fill_polygon
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
    height, width = image.image.shape
    if region.mask is not None:
        if region.mask.shape != mask.shape:
            rows, cols = region.mask.shape
            raise ConfigError(
                f"region mask: expected a picture of {width} x {height} px, the size of the "
                f"flattened reference image, got {cols} x {rows}: draw it on that image"
            )
        mask &= region.mask
    if region.polygon is not None:
        corners = np.ascontiguousarray(region.polygon, dtype=np.float64)
        mask &= fill_polygon(corners, height, width)
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
