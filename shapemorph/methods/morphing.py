"""Resample a deformed picture in the frame of the reference, through a warp."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.image import CalibratedImage, GreyImage
from shapemorph.core.matching import Warp
from shapemorph.core.mesh import TexturedMesh
from shapemorph.kernels import texture as kernel
from shapemorph.methods.calibrating import POINTS_AT_ONCE, continue_outside
from shapemorph.methods.shading import map_under_image, prepare_shader, stack_pictures
from shapemorph.methods.warping import warp_points

LEVELS = 5
SAMPLED = 4000  # pixels that are asked how far the warp narrows them
NARROW_PLACES = 5.0  # percentile of their widths that textures are kept sharp for
LEAST_WIDTH = 1e-3  # px


def morph_surface(
    mesh: TexturedMesh, image: CalibratedImage, warp: Warp, shape: tuple[int, int]
) -> GreyImage:
    """Resample a textured surface in the reference frame, straight from its texture.

    Every pixel averages the texture over the parallelogram that the warp makes of it.

    Parameters
    ----------
    mesh : TexturedMesh
        The deformed one.
    image : CalibratedImage
        Of that mesh.
    warp : Warp
        Reference px -> deformed px.
    shape : (int, int)
        Height and width of the reference picture.

    Returns
    -------
    GreyImage
        The mask holds the pixels whose centre meets the deformed surface.
    """
    under, narrowest = map_under_image(mesh, image), _narrowest(image, warp, shape)
    shader = prepare_shader(mesh, image.chart, under, narrowest=narrowest)
    grey = np.zeros(shape[0] * shape[1], np.float32)
    mask = np.zeros(shape[0] * shape[1], dtype=bool)
    for start in range(0, len(grey), POINTS_AT_ONCE):
        some = slice(start, min(start + POINTS_AT_ONCE, len(grey)))
        targets, gradient = warp_points(warp, _pixel_centres(some, shape[1]))
        found, triangle = shader.shade(targets, gradient)
        mask[some] = (triangle >= 0) & np.isfinite(found)
        grey[some] = np.where(mask[some], found, np.float32(0))
    mask = mask.reshape(shape)
    return GreyImage(continue_outside(grey.reshape(shape), mask), mask)


def morph_image(image: GreyImage, warp: Warp, shape: tuple[int, int]) -> GreyImage:
    """Resample a plain picture in the reference frame by cubic splines.

    Parameters
    ----------
    image : GreyImage
        The deformed picture.
    warp : Warp
        Reference px -> deformed px.
    shape : (int, int)
        Height and width of the reference picture.

    Returns
    -------
    GreyImage
        The mask holds the pixels whose centre falls nearest to one of the deformed mask.
    """
    filled = continue_outside(image.grey, image.mask)
    texels, table = stack_pictures([filled], [0], base=0, levels=LEVELS)
    grey = np.zeros(shape[0] * shape[1], np.float32)
    mask = np.zeros(shape[0] * shape[1], dtype=bool)
    for start in range(0, len(grey), POINTS_AT_ONCE):
        some = slice(start, min(start + POINTS_AT_ONCE, len(grey)))
        targets, gradient = warp_points(warp, _pixel_centres(some, shape[1]))
        found = kernel.resample(targets, gradient, texels, table)
        inside = np.flatnonzero(np.isfinite(found))
        nearest = np.rint(targets[inside]).astype(np.int64)
        rows = np.clip(nearest[:, 1], 0, image.shape[0] - 1)
        cols = np.clip(nearest[:, 0], 0, image.shape[1] - 1)
        inside = inside[image.mask[rows, cols]]
        mask[start + inside] = True
        grey[start + inside] = found[inside]
    mask = mask.reshape(shape)
    return GreyImage(continue_outside(grey.reshape(shape), mask), mask)


def _narrowest(image: CalibratedImage, warp: Warp, shape: tuple[int, int]) -> float:
    """Width of a pixel of the reference in the deformed picture, px, where it is narrow."""
    step = max(1, round(np.sqrt(shape[0] * shape[1] / SAMPLED)))
    cols, rows = np.meshgrid(np.arange(0, shape[1], step), np.arange(0, shape[0], step))
    points = np.stack([cols.ravel(), rows.ravel()], axis=1).astype(np.float64)
    targets, gradient = warp_points(warp, points)
    places = np.rint(np.where(np.isfinite(targets), targets, -1.0)).astype(np.int64)
    height, width = image.image.shape
    near = np.flatnonzero(((places >= 0) & (places < (width, height))).all(axis=1))
    near = near[image.image.mask[places[near, 1], places[near, 0]]]
    if len(near) == 0:
        return 1.0
    widths = np.linalg.svd(gradient[near], compute_uv=False)[:, 1]
    return float(max(np.percentile(widths, NARROW_PLACES), LEAST_WIDTH))


def _pixel_centres(some: slice, width: int) -> Floats:
    """Positions (x, y) of pixels numbered row by row."""
    rows, cols = np.divmod(np.arange(some.start, some.stop), width)
    return np.stack([cols, rows], axis=1).astype(np.float64)
