"""Affine views of a picture in which its speckle is round."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys
from shapemorph.methods.contrast import Bytes, Pattern, byte_picture
from shapemorph.methods.mask_box import tight_map
from shapemorph.methods.speckle_ellipse import SpeckleField, measure_speckle, seen_from

ALIKE = 1.3  # one view serves all if the speckle varies less than this in shape ...
ALIKE_SIZE = 1.6  # ... and less than this in size
TILE = 128.0  # width of a tile, in standard deviations of the speckle
OVERLAP = 20.0  # margin that descriptors may reach into, likewise
LEAST_BLUR = 0.3  # px: less is none
REDUCED, ALIAS = 0.8, 0.35  # a view smaller than this is of pixels that were blurred so far, px


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


@dataclass(frozen=True, slots=True)
class Softness:
    """How far a picture is out of focus, and how far its views shall be.

    Attributes
    ----------
    lens : float
        Standard deviation of the blur that is in the picture, px.
    wanted : float
        Standard deviation of the blur, round, that its views shall show in all, in
        standard deviations of the sharp speckle.
    """

    lens: float
    wanted: float


SHARP = Softness(0.0, 0.0)


def round_views(
    pattern: Pattern, field: SpeckleField, *, std: float, softness: Softness = SHARP
) -> list[View]:
    """Show the whole picture, in one view or several, with a round speckle of given size.

    One view where the speckle has nearly the same shape everywhere, tiles otherwise.

    Parameters
    ----------
    pattern : Pattern
    field : SpeckleField
        Of that pattern, without the blur of the lens.
    std : float
        Standard deviation that the speckle gets in the views, px, with all its blur.
    softness : Softness
        Blurs the views until they look as round and as soft as wanted.
    """
    height, width = pattern.shape
    low, high = np.zeros(2), np.array([width - 1.0, height - 1.0])
    std = std / np.hypot(1.0, softness.wanted)
    if is_uniform(field):
        views = [view_of(pattern, rounding(field.median, std), (low, high), 0.0)]
        return [_softened(view, softness, std) for view in views if view is not None]
    across, down = (max(1, round(v / (TILE * field.std))) for v in (width, height))
    views = []
    for j in range(down):
        for i in range(across):
            corner = np.array([i / across, j / down]) * high
            opposite = np.array([(i + 1) / across, (j + 1) / down]) * high
            local = rounding(field.mean_over(corner, opposite), std)
            views.append(view_of(pattern, local, (corner, opposite), OVERLAP * field.std))
    return [_softened(view, softness, std) for view in views if view is not None]


def measure_in_view(pattern: Pattern, matrix: Floats, *, window: float) -> SpeckleField | None:
    """Measure the speckle where a linear map has made it about round: grain of any length.

    Parameters
    ----------
    pattern : Pattern
    matrix : (2, 2)
    window : float
        Width over which moments are averaged, px of the view.

    Returns
    -------
    SpeckleField or None
        Of the picture itself, not of the view; None where there is no pattern.
    """
    corner = np.array(pattern.shape[::-1]) - 1.0
    view = view_of(pattern, matrix, (np.zeros(2), corner), 0.0)
    if view is None:
        return None
    seen = Pattern(
        (view.grey.astype(np.float32) - np.float32(128)) / np.float32(40),
        view.mask,
        pattern.contrast,
    )
    field = measure_speckle(seen, window=window)
    return None if field is None else seen_from(field, view.matrix, pattern.shape)


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


def blur_anisotropic(values: Greys | Bytes, covariance: Floats) -> Greys | Bytes:
    """Blur by a Gaussian of any covariance (2, 2), px^2 in the order x, y."""
    import cv2

    eigenvalues, axes = np.linalg.eigh(covariance)
    if eigenvalues[1] < LEAST_BLUR**2:
        return values
    reach = int(np.ceil(3 * np.sqrt(eigenvalues[1])))
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    along = np.stack([x, y], -1) @ axes
    weights = np.exp(-0.5 * (along**2 / np.maximum(eigenvalues, LEAST_BLUR**2)).sum(-1))
    kernel = weights / weights.sum()
    blurred: Greys | Bytes = cv2.filter2D(values, -1, kernel, borderType=cv2.BORDER_REPLICATE)
    return blurred


def _reduction_blur(matrix: Floats) -> Floats:
    """(2, 2) covariance of a blur before a map that makes a picture smaller, px^2."""
    _left, scales, axes = np.linalg.svd(matrix)
    widths = np.where(scales < REDUCED, (ALIAS / scales) ** 2, 0.0)
    covariance: Floats = (axes.T * widths) @ axes
    return covariance


def _softened(view: View, softness: Softness, std: float) -> View:
    """Blur a view so far that its blur is round and as wide as wanted."""
    if softness.wanted == 0:
        return view
    matrix = view.matrix[:, :2]
    missing = (std * softness.wanted) ** 2 * np.eye(2) - softness.lens**2 * matrix @ matrix.T
    grey = np.asarray(blur_anisotropic(view.grey, missing), np.uint8)
    return View(grey, view.mask, view.matrix)


def view_of(
    pattern: Pattern, rounded: Floats, core: tuple[Floats, Floats], overlap: float
) -> View | None:
    """See the core rectangle and some overlap through the map; features only in the core.

    The view is turned where that makes it much smaller. None if the mask is empty there.
    """
    import cv2

    low = np.maximum(np.floor(core[0] - overlap), 0).astype(int)
    high = np.minimum(np.ceil(core[1] + overlap), np.array(pattern.shape[::-1]) - 1).astype(int)
    part = np.s_[low[1] : high[1] + 1, low[0] : high[0] + 1]
    mask = pattern.mask[part]
    if not mask.any():
        return None
    matrix, (height, width) = tight_map(rounded, mask)
    source = blur_anisotropic(byte_picture(pattern.values[part]), _reduction_blur(rounded))
    grey = cv2.warpAffine(source, matrix, (width, height), flags=cv2.INTER_CUBIC, borderValue=128.0)
    inside = cv2.warpAffine(mask.astype(np.uint8), matrix, (width, height), flags=cv2.INTER_NEAREST)
    matrix[:, 2] -= matrix[:, :2] @ low
    window = np.zeros((height, width), np.uint8)
    outline = _corners(*core) @ matrix[:, :2].T + matrix[:, 2]
    cv2.fillConvexPoly(window, np.rint(outline).astype(np.int32), 1)
    seen = (inside > 0) & (window > 0)
    return View(grey, seen, matrix) if seen.any() else None


def _corners(low: Floats, high: Floats) -> Floats:
    return np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
