"""Make the calibrated image of a mesh from its chart."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys
from shapemorph.core.errors import StageError
from shapemorph.core.image import CalibratedImage, Chart, GreyImage
from shapemorph.core.mesh import TexturedMesh
from shapemorph.kernels.raster import Triangles, rasterise
from shapemorph.methods.charting import picture_shape
from shapemorph.methods.distortion import chart_handedness
from shapemorph.methods.shading import map_textures, prepare_shader

POINTS_AT_ONCE = 1 << 18
EDGE_GROWTH = 4  # px that grey is continued beyond the mask


def calibrate(mesh: TexturedMesh, chart: Chart) -> tuple[CalibratedImage, float]:
    """Find triangle, place in it and grey of every pixel of a chart.

    Parameters
    ----------
    mesh : TexturedMesh
    chart : Chart
        Of that mesh.

    Returns
    -------
    CalibratedImage
    float
        Overlap: pixel centres claimed once too often, as a share of the covered ones.

    Raises
    ------
    StageError
        If no pixel lies on the surface.
    """
    height, width = picture_shape(chart)
    px, faces = np.ascontiguousarray(chart.vertex_px), np.ascontiguousarray(chart.faces)
    triangle, barycentric, overlaps = rasterise(px, faces, chart_handedness(chart), height, width)
    mask = triangle >= 0
    if not mask.any():
        raise StageError(
            f"{mesh.name}: no pixel of the flattened image lies on the surface at "
            f"{chart.px_per_mm:.3g} px/mm: raise flatten.px_per_mm"
        )
    grey = _shade_pixels(mesh, chart, triangle, barycentric)
    thin = mask & ~np.isfinite(grey)  # all of what it would average lies beside the surface
    triangle[thin], barycentric[thin], grey[thin] = -1, np.nan, 0.0
    mask &= ~thin
    image = GreyImage(continue_outside(grey, mask), mask)
    return CalibratedImage(image, chart, triangle, barycentric), overlaps / int(mask.sum())


def _shade_pixels(
    mesh: TexturedMesh, chart: Chart, triangle: Triangles, barycentric: Floats
) -> Greys:
    """Grey of the pixels that have a triangle."""
    under, mask = map_textures(mesh, chart, (triangle, barycentric)), triangle >= 0
    shader = prepare_shader(mesh, chart, under)
    grey = np.zeros(mask.shape, np.float32)
    band = max(POINTS_AT_ONCE // mask.shape[1], 1)
    for start in range(0, len(mask), band):
        rows, cols = np.nonzero(mask[start : start + band])
        rows += start
        points = np.stack([cols, rows], axis=1).astype(np.float64)
        hints = triangle[rows, cols].astype(np.int64)
        grey[rows, cols], _ = shader.shade(points, np.eye(2)[None], hints)
    return grey


def continue_outside(grey: Greys, mask: Bools) -> Greys:
    """Continue a picture a few px beyond its mask, so that splines do not ring at its edge.

    Each step gives the pixels beside known ones the mean of their known neighbours; what
    lies farther out gets the mean of the picture.
    """
    import cv2

    if mask.all():
        return grey.astype(np.float32)
    known = mask.astype(np.float32)
    filled = np.where(mask, grey, np.float32(0))
    for _ in range(EDGE_GROWTH):
        total = cv2.boxFilter(filled, -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
        count = cv2.boxFilter(known, -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
        beside = (known == 0) & (count > 0.5)
        filled[beside] = total[beside] / count[beside]
        known[beside] = 1
    mean = grey[mask].mean() if mask.any() else np.float32(0)
    return np.where(known > 0, filled, mean).astype(np.float32)
