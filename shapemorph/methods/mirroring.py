"""A calibrated image as it looks from the other side of the surface."""

from dataclasses import replace

import numpy as np

from shapemorph.core.image import CalibratedImage, GreyImage


def mirror_image(image: CalibratedImage) -> CalibratedImage:
    """Exchange left and right; every pixel keeps its place on the mesh.

    Parameters
    ----------
    image : CalibratedImage
        Of one page.
    """
    chart, width = image.chart, image.image.shape[1]
    flipped = np.column_stack([width - 1 - chart.vertex_px[:, 0], chart.vertex_px[:, 1]])
    picture = GreyImage(
        np.ascontiguousarray(image.image.grey[:, ::-1]),
        np.ascontiguousarray(image.image.mask[:, ::-1]),
    )
    return CalibratedImage(
        picture,
        replace(chart, vertex_px=flipped),
        triangle=np.ascontiguousarray(image.triangle[:, ::-1]),
        barycentric=np.ascontiguousarray(image.barycentric[:, ::-1]),
    )
