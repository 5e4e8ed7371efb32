"""Dots in a picture: found as spots that differ from what surrounds them, centred by grey."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys, Ints

_WINDOWS = (31, 81, 201)  # px: widths over which a local mean is taken
_LEAST_AREA = 20  # px²
_MOST_AREA = 0.005  # of the picture
_SOLID = 0.88  # share of its convex hull that a dot fills
_SLENDER = 8.0  # long over short axis that a dot may have
_CONTRAST = 0.08  # of the range of grey between dot and surroundings
_MARGIN = 0.35, 3  # of the dot's width, or px: of the surroundings that are looked at
_EVEN = 0.4  # of the contrast: scatter of the surroundings about a plane


@dataclass(frozen=True, slots=True, eq=False)
class Dots:
    """Dots of one picture.

    Attributes
    ----------
    centres : (N, 2) float64
        Centroids by grey, px.
    areas : (N,) float64
        px².
    """

    centres: Floats
    areas: Floats


def find_dots(grey: Greys, *, dark: bool, least_px: float | None = None) -> Dots:
    """Find the dots of a picture.

    Parameters
    ----------
    grey : (H, W)
        In [0, 1].
    dark : bool
        Whether dots are darker than what surrounds them.
    least_px : float or None
        Diameter of a disc as large as the smallest dot, px; None: as small as can be told.

    Returns
    -------
    Dots
        Without order; things that look like dots are among them.
    """
    picture = grey if dark else 1.0 - grey
    least = _LEAST_AREA if least_px is None else max(_LEAST_AREA, 0.25 * np.pi * least_px**2)
    centres: list[Floats] = []
    areas: list[float] = []
    for window in _WINDOWS:
        for box, spot in _spots(picture, window, least):
            found = _centred(picture, box, spot)
            if found is not None:
                centres.append(found[0])
                areas.append(found[1])
    if not centres:
        return Dots(np.zeros((0, 2)), np.zeros(0))
    return _once(np.array(centres), np.array(areas))


def _spots(picture: Greys, window: int, least: float) -> list[tuple[Ints, Bools]]:
    """List connected dark spots of a sound size: box (x, y, width, height) and pixels in it."""
    import cv2

    height, width = picture.shape
    eight = np.round(255 * np.clip(picture, 0, 1)).astype(np.uint8)
    dark = cv2.adaptiveThreshold(
        eight,
        1,
        cv2.ADAPTIVE_THRESH_MEAN_C,
        cv2.THRESH_BINARY_INV,
        window,
        255 * _CONTRAST / 2,
    )
    count, labels, stats, _ = cv2.connectedComponentsWithStats(dark, connectivity=4)
    x, y, w, h, area = stats.T
    most = min(_MOST_AREA * height * width, (0.8 * window) ** 2)
    inside = (x > 0) & (y > 0) & (x + w < width) & (y + h < height)
    sound = inside & (area >= least) & (area <= most) & (area > 0.3 * w * h)
    sound[0] = False
    return [
        (stats[k, :4].astype(np.int64), labels[y[k] : y[k] + h[k], x[k] : x[k] + w[k]] == k)
        for k in range(count)
        if sound[k] and _is_solid(labels[y[k] : y[k] + h[k], x[k] : x[k] + w[k]] == k)
    ]


def _is_solid(spot: Bools) -> bool:
    """Say whether a spot is convex and not too slender."""
    import cv2

    contours, _ = cv2.findContours(spot.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    outline = max(contours, key=len).reshape(-1, 2)
    hull = cv2.convexHull(outline)
    area = float(spot.sum())
    filled = cv2.contourArea(hull) + 0.5 * cv2.arcLength(hull, True) + 1  # noqa: FBT003 - closed
    if area < _SOLID * filled:
        return False
    rows, cols = np.nonzero(spot)
    spread = np.linalg.eigvalsh(np.cov(np.stack([cols, rows])) + np.eye(2) / 12)
    return bool(spread[1] < _SLENDER**2 * spread[0])


def _centred(picture: Greys, box: Ints, spot: Bools) -> tuple[Floats, float] | None:
    """Centroid by grey and area of a spot; None where its surroundings are not even."""
    import cv2

    margin = int(max(_MARGIN[0] * float(min(box[2:])), _MARGIN[1]))
    (low_x, low_y), (high_x, high_y) = box[:2] - margin, box[:2] + box[2:] + margin
    height, width = picture.shape
    if low_x < 0 or low_y < 0 or high_x > width or high_y > height:
        return None
    patch = picture[low_y:high_y, low_x:high_x].astype(np.float64)
    own = np.pad(spot, margin).astype(np.uint8)
    reach = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * margin + 1, 2 * margin + 1))
    near = cv2.dilate(own, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))) > 0
    ring = (cv2.dilate(own, reach) > 0) & ~near
    surround = _plane_over(patch, ring)
    inner = cv2.erode(own, np.ones((3, 3), np.uint8)) > 0
    inside = float(np.median(patch[inner if inner.any() else own > 0]))
    contrast = float(np.median(surround[own > 0])) - inside
    if contrast < _CONTRAST or float((patch - surround)[ring].std()) > _EVEN * contrast:
        return None
    weight = np.where(near, (surround - patch) / contrast, 0.0)
    total = float(weight.sum())
    rows, cols = np.indices(patch.shape)
    centre = np.array([(weight * cols).sum(), (weight * rows).sum()]) / total
    return centre + np.array([low_x, low_y]), total


def _plane_over(patch: Floats, where: Bools) -> Floats:
    """Plane through the grey of some pixels, over the whole patch."""
    rows, cols = np.indices(patch.shape)
    basis = np.stack([np.ones(patch.size), cols.ravel(), rows.ravel()], axis=1)
    values = np.linalg.lstsq(basis[where.ravel()], patch[where])[0]
    plane: Floats = (basis @ values).reshape(patch.shape)
    return plane


def _once(centres: Floats, areas: Floats) -> Dots:
    """Keep one of several findings of a dot: the last, from the widest surroundings."""
    from scipy.spatial import cKDTree

    pairs = cKDTree(centres).query_pairs(1.0 + 0.2 * float(np.sqrt(np.median(areas))))
    kept = np.ones(len(centres), dtype=np.bool_)
    for one, other in pairs:
        kept[min(one, other)] = False
    return Dots(centres[kept], areas[kept])
