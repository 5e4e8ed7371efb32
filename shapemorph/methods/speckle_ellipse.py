"""The local shape of a speckle, measured in one picture by its second moments.

The autocorrelation of a pattern falls off as exp(-d^T S^-1 d / 4); near its top it is
the covariance of the grey gradients that says how fast. A speckle that was round before
the deformation has become the ellipse that the deformation makes of a circle.
"""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys
from shapemorph.methods.contrast import Pattern

BLUR = 0.7  # px, before differentiating: noise and pixels have no say
OPERATOR = 11 / 16  # px^2 that Scharr's operator adds to a Gaussian speckle, to first order
LEAST = 0.25  # share of the measured covariance that the corrections must leave
LEAST_SHARP = 0.1  # share of the covariance that the blur of the lens must leave
MARGIN = 3  # px beside the rim of the mask that gradients are not trusted
LATTICE = 8  # px between the points of the field


@dataclass(frozen=True, slots=True, eq=False)
class SpeckleField:
    """Covariance of the speckle over a picture.

    Attributes
    ----------
    log_covariance : (R, C, 2, 2) float64
        Matrix logarithm of S, px^2, at (x, y) = lattice * (c + 0.5, r + 0.5) - 0.5.
        Where the mask leaves too little to measure: the median.
    trusted : (R, C) bool
        Where it was measured.
    """

    log_covariance: Floats
    trusted: Bools

    @property
    def median(self) -> Floats:
        """(2, 2) median of the logarithm over the trusted part."""
        middle: Floats = np.median(self.log_covariance[self.trusted], axis=0)
        return middle

    @property
    def std(self) -> float:
        """Standard deviation of a round speckle of the same area, px, median."""
        return float(np.exp(0.25 * np.trace(self.median)))

    def mean_over(self, low: Floats, high: Floats) -> Floats:
        """(2, 2) mean of the logarithm over a rectangle, px; the median where nothing is."""
        rows, cols = self.trusted.shape
        c0, r0 = (int(v // LATTICE) for v in low)
        c1, r1 = (int(v // LATTICE) + 1 for v in high)
        part = np.s_[max(r0, 0) : min(r1, rows), max(c0, 0) : min(c1, cols)]
        trusted = self.trusted[part]
        if not trusted.any():
            return self.median
        mean: Floats = self.log_covariance[part][trusted].mean(axis=0)
        return mean


def measure_speckle(pattern: Pattern, *, window: float) -> SpeckleField | None:
    """Measure the local covariance of the speckle.

    Parameters
    ----------
    pattern : Pattern
    window : float
        Width over which moments are averaged, px: the wider the steadier, the narrower
        the better it follows a stretch that varies.

    Returns
    -------
    SpeckleField or None
        None where no part of the picture has a pattern.
    """
    moments, share = _local_moments(pattern, window / np.sqrt(12.0))
    variance = moments[..., 4] - moments[..., 3] ** 2
    trusted = (share > 0.15) & (variance > 1e-3)
    if not trusted.any():
        return None
    xx, xy, yy = (moments[..., k] / np.maximum(variance, 1e-3) for k in range(3))
    gradients = np.stack([np.stack([xx, xy], -1), np.stack([xy, yy], -1)], -2)
    eigenvalues, axes = np.linalg.eigh(gradients)
    raw = 0.5 / np.maximum(eigenvalues, 1e-6)
    covariance = np.maximum(raw - (BLUR**2 + OPERATOR), LEAST * raw)
    logarithm = (axes * np.log(covariance)[..., None, :]) @ axes.swapaxes(-1, -2)
    logarithm[~trusted] = np.median(logarithm[trusted], axis=0)
    return SpeckleField(logarithm, trusted)


def without_blur(field: SpeckleField, lens: float) -> SpeckleField:
    """Shape of the speckle as a picture without the blur of the lens would show it.

    Parameters
    ----------
    field : SpeckleField
    lens : float
        Standard deviation of that blur, px.
    """
    eigenvalues, axes = np.linalg.eigh(field.log_covariance)
    covariance = np.exp(eigenvalues)
    sharp = np.maximum(covariance - lens**2, LEAST_SHARP * covariance)
    logarithm = (axes * np.log(sharp)[..., None, :]) @ axes.swapaxes(-1, -2)
    return SpeckleField(logarithm, field.trusted)


def mean_covariance(values: Greys, mask: Bools) -> Floats | None:
    """(2, 2) covariance of the speckle over a whole picture, px^2; None without a pattern."""
    import cv2

    smooth = cv2.GaussianBlur(values, (0, 0), BLUR)
    along_x = cv2.Scharr(smooth, cv2.CV_32F, 1, 0)[mask] / 32
    along_y = cv2.Scharr(smooth, cv2.CV_32F, 0, 1)[mask] / 32
    if len(along_x) == 0:
        return None
    variance = float(smooth[mask].var(dtype=np.float64))
    xx, xy, yy = (
        float((one * other).mean(dtype=np.float64))
        for one, other in ((along_x, along_x), (along_x, along_y), (along_y, along_y))
    )
    products = np.array([[xx, xy], [xy, yy]]) / max(variance, 1e-6)
    eigenvalues, axes = np.linalg.eigh(products)
    if eigenvalues[0] <= 0 or variance < 1e-3:
        return None
    raw = 0.5 / eigenvalues
    covariance: Floats = (axes * np.maximum(raw - (BLUR**2 + OPERATOR), LEAST * raw)) @ axes.T
    return covariance


def seen_from(field: SpeckleField, matrix: Floats, shape: tuple[int, int]) -> SpeckleField:
    """Carry the shape of a speckle over to the picture that a view was made of.

    Parameters
    ----------
    field : SpeckleField
        Of the view.
    matrix : (2, 3)
        Position in the view = matrix[:, :2] @ position in the picture + matrix[:, 2].
    shape : (H, W)
        Of the picture, px.
    """
    rows, cols = np.mgrid[: -(-shape[0] // LATTICE), : -(-shape[1] // LATTICE)]
    place = (np.stack([cols, rows], -1) + 0.5) * LATTICE - 0.5
    place = (place @ matrix[:, :2].T + matrix[:, 2] + 0.5) / LATTICE
    c, r = np.floor(place).astype(np.int64).transpose(2, 0, 1)
    height, width = field.trusted.shape
    inside = (c >= 0) & (r >= 0) & (c < width) & (r < height)
    r, c = np.where(inside, r, 0), np.where(inside, c, 0)
    trusted = inside & field.trusted[r, c]
    back = np.linalg.inv(matrix[:, :2])
    eigenvalues, axes = np.linalg.eigh(field.log_covariance[r, c])
    there = (axes * np.exp(eigenvalues)[..., None, :]) @ axes.swapaxes(-1, -2)
    eigenvalues, axes = np.linalg.eigh(back @ there @ back.T)
    logarithm = (axes * np.log(eigenvalues)[..., None, :]) @ axes.swapaxes(-1, -2)
    if trusted.any():
        logarithm[~trusted] = np.median(logarithm[trusted], axis=0)
    return SpeckleField(logarithm, trusted if trusted.any() else np.ones_like(trusted))


def _local_moments(pattern: Pattern, sigma: float) -> tuple[Floats, Floats]:
    """(R, C, 5) means of gx gx, gx gy, gy gy, g, g g inside the mask, and (R, C) its share."""
    import cv2

    smooth = cv2.GaussianBlur(pattern.values, (0, 0), BLUR)
    along_x = cv2.Scharr(smooth, cv2.CV_32F, 1, 0) / 32
    along_y = cv2.Scharr(smooth, cv2.CV_32F, 0, 1) / 32
    core = erode(pattern.mask, MARGIN).astype(np.float32)
    share = _lattice_mean(core, sigma)
    fields = (along_x**2, along_x * along_y, along_y**2, smooth, smooth**2)
    means = [_lattice_mean(field * core, sigma) / np.maximum(share, 1e-6) for field in fields]
    return np.stack(means, axis=-1).astype(np.float64), share.astype(np.float64)


def _lattice_mean(field: Greys, sigma: float) -> Greys:
    import cv2

    height, width = field.shape
    rows, cols = -(-height // LATTICE), -(-width // LATTICE)
    padded = np.zeros((rows * LATTICE, cols * LATTICE), np.float32)
    padded[:height, :width] = field
    coarse = cv2.resize(padded, (cols, rows), interpolation=cv2.INTER_AREA)
    mean: Greys = cv2.GaussianBlur(coarse, (0, 0), sigma / LATTICE, borderType=cv2.BORDER_CONSTANT)
    return mean


def erode(mask: Bools, margin: int) -> Bools:
    """Keep pixels of which the whole square neighbourhood is inside mask and picture."""
    import cv2

    kernel = np.ones((2 * margin + 1, 2 * margin + 1), np.uint8)
    shrunk = cv2.erode(
        mask.astype(np.uint8), kernel, borderType=cv2.BORDER_CONSTANT, borderValue=0.0
    )
    inside: Bools = shrunk.astype(bool)
    return inside
