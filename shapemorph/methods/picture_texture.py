"""A calibrated image as the texture of its mesh."""

import numpy as np

from shapemorph.core.arrays import Floats, Greys
from shapemorph.core.image import CalibratedImage, GreyImage
from shapemorph.core.mesh import TexturedMesh, textured_mesh

GROWTH = 3  # px around the surface that get its grey, so that filters meet no rim


def wear_picture(mesh: TexturedMesh, image: CalibratedImage) -> TexturedMesh:
    """Give a mesh the flattened picture for its texture.

    Parameters
    ----------
    mesh : TexturedMesh
        Geometry, mm.
    image : CalibratedImage
        Of that mesh; of a face that it shows several times, the one that counts is taken.

    Returns
    -------
    TexturedMesh
        The vertices of `mesh` and the faces that the picture shows; one texture.
    """
    chart = image.chart
    home = np.ones(len(chart.faces), dtype=bool) if chart.home is None else chart.home
    faces = chart.vertex_ids[chart.faces[home]]
    uv = _texture_coordinates(chart.corner_px[home], image.image.shape)
    texture = (_grown(image.image),)
    which = np.zeros(len(faces), dtype=np.int64)
    return textured_mesh(mesh.vertices, faces, uv, which, texture, name=mesh.name)


def _texture_coordinates(points_px: Floats, shape: tuple[int, int]) -> Floats:
    """Turn px with centres at integers into coordinates from the lower left corner, 0 to 1."""
    height, width = shape
    return np.stack(
        [(points_px[..., 0] + 0.5) / width, 1.0 - (points_px[..., 1] + 0.5) / height], axis=-1
    )


def _grown(picture: GreyImage) -> Greys:
    """Spread the grey at the rim outward, and the mean grey over the rest."""
    import cv2

    inside = picture.mask.astype(np.float32)
    total, count = picture.grey * inside, inside
    for _ in range(GROWTH):
        around, share = (cv2.blur(each, (3, 3)) for each in (total, count))
        new = (count == 0) & (share > 1e-6)
        total = np.where(new, around / np.maximum(share, 1e-6), total)
        count = np.where(new, np.float32(1.0), count)
    mean = picture.grey[picture.mask].mean()
    grown: Greys = np.where(count > 0, total, mean).astype(np.float32)
    return grown
