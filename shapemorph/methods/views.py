"""Affine views of a picture in which its speckle is round."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.methods.contrast import Bytes, Pattern, byte_picture
from shapemorph.methods.speckle_ellipse import SpeckleField

ALIKE = 1.3  # one view serves all if the speckle varies less than this in shape ...
ALIKE_SIZE = 1.6  # ... and less than this in size
TILE = 128.0  # width of a tile, in standard deviations of the speckle
OVERLAP = 20.0  # margin that descriptors may reach into, likewise


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A piece of a picture, seen through an affine map.

    Attributes
    ----------
    grey : (H, W) uint8
    mask : (H, W) bool
        Where features may lie.
    matrix : (2, 3) float64
        Position in the view = matrix[:, :2] @ position in the picture + matrix[:, 2].
    """

    grey: Bytes
    mask: Bools
    matrix: Floats


def round_views(pattern: Pattern, field: SpeckleField, *, std: float) -> list[View]:
    """Show the whole picture, in one view or several, with a round speckle of given size.

    One view where the speckle has nearly the same shape everywhere, tiles otherwise.

    Parameters
    ----------
    pattern : Pattern
    field : SpeckleField
        Of that pattern.
    std : float
        Standard deviation that the speckle gets in the views, px.
    """
    height, width = pattern.shape
    low, high = np.zeros(2), np.array([width - 1.0, height - 1.0])
    if is_uniform(field):
        return _visible([_view(pattern, rounding(field.median, std), (low, high), 0.0)])
    across, down = (max(1, round(v / (TILE * field.std))) for v in (width, height))
    views = []
    for j in range(down):
        for i in range(across):
            corner = np.array([i / across, j / down]) * high
            opposite = np.array([(i + 1) / across, (j + 1) / down]) * high
            local = rounding(field.mean_over(corner, opposite), std)
            views.append(_view(pattern, local, (corner, opposite), OVERLAP * field.std))
    return _visible(views)


def is_uniform(field: SpeckleField) -> bool:
    """Tell whether 98 % of the speckles are like the median one."""
    differences = np.linalg.eigvalsh(field.log_covariance[field.trusted] - field.median)
    size = np.exp(np.abs(differences.sum(axis=-1)) / 4)
    shape = np.exp((differences[:, 1] - differences[:, 0]) / 2)
    return bool((np.percentile(shape, 98) < ALIKE) & (np.percentile(size, 98) < ALIKE_SIZE))


def rounding(log_covariance: Floats, std: float) -> Floats:
    """(2, 2) map that makes a speckle round with the given standard deviation."""
    eigenvalues, axes = np.linalg.eigh(log_covariance)
    matrix: Floats = std * (axes * np.exp(-0.5 * eigenvalues)) @ axes.T
    return matrix


def _view(pattern: Pattern, rounded: Floats, core: tuple[Floats, Floats], overlap: float) -> View:
    """See the core rectangle and some overlap through the map; features only in the core."""
    import cv2

    limit = np.array(pattern.shape[::-1]) - 1.0
    low, high = np.maximum(core[0] - overlap, 0), np.minimum(core[1] + overlap, limit)
    corners = _corners(low, high) @ rounded.T
    shift = -corners.min(axis=0)
    matrix = np.column_stack([rounded, shift])
    width, height = (int(v) for v in np.ceil(corners.max(axis=0) + shift) + 1)
    strongest = float(np.linalg.svd(rounded, compute_uv=False)[0])
    source = byte_picture(pattern.values)
    if strongest < 0.8:
        source = cv2.GaussianBlur(source, (0, 0), 0.35 / strongest)
    grey = cv2.warpAffine(source, matrix, (width, height), flags=cv2.INTER_CUBIC, borderValue=128.0)
    inside = cv2.warpAffine(
        pattern.mask.astype(np.uint8), matrix, (width, height), flags=cv2.INTER_NEAREST
    )
    window = np.zeros((height, width), np.uint8)
    outline = _corners(*core) @ rounded.T + shift
    cv2.fillConvexPoly(window, np.rint(outline).astype(np.int32), 1)
    return View(grey, (inside > 0) & (window > 0), matrix)


def _corners(low: Floats, high: Floats) -> Floats:
    return np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])


def _visible(views: list[View]) -> list[View]:
    return [view for view in views if view.mask.any()]
