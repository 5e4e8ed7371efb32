"""Features with their own local frames, spread over the picture."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.methods.speckle_ellipse import erode
from shapemorph.methods.views import View

MARGIN = 4  # px of a view beside the rim that may hold no feature
LENGTH = 4000.0  # of a descriptor: products of whole numbers stay exact in 32-bit floats


@dataclass(frozen=True, slots=True, eq=False)
class Features:
    """Places that can be recognised.

    Attributes
    ----------
    points : (N, 2) float64
        Position in the picture, px.
    descriptors : (N, 128) float32
        RootSIFT, length about 4000, whole numbers: their products are exact in any order.
    frames : (N, 2, 2) float64
        Columns: the feature's own unit axes as vectors of the picture, px.
    """

    points: Floats
    descriptors: Greys
    frames: Floats

    def __len__(self) -> int:
        return len(self.points)


def detect_features(
    views: Sequence[View], *, contrast: float, cell: float, per_cell: int
) -> Features:
    """Detect SIFT features in all views and keep the strongest of every cell.

    Parameters
    ----------
    views : sequence of View
    contrast : float
        Contrast threshold of SIFT.
    cell : float
        Width of a cell, px of the picture.
    per_cell : int
        Features kept in each cell.

    References
    ----------
    D. Lowe, IJCV 60 (2004), doi:10.1023/B:VISI.0000029664.99615.94;
    R. Arandjelovic, A. Zisserman, CVPR 2012, doi:10.1109/CVPR.2012.6248018 (RootSIFT).
    """
    found = [_detect(view, contrast, _budget(view, cell, per_cell)) for view in views]
    raw = np.concatenate([np.empty((0, 7))] + [keypoints for keypoints, _ in found])
    descriptors = np.concatenate([np.empty((0, 128), np.float32)] + [d for _, d in found])
    chosen = _strongest(raw[:, :2], raw[:, 6], cell, per_cell)
    raw = raw[chosen]
    frames = np.ascontiguousarray(raw[:, 2:6].reshape(-1, 2, 2))
    return Features(np.ascontiguousarray(raw[:, :2]), _root(descriptors[chosen]), frames)


def _budget(view: View, cell: float, per_cell: int) -> int:
    """Features worth computing in a view: somewhat more than its cells will keep."""
    area = view.mask.sum() / abs(np.linalg.det(view.matrix[:, :2]))
    return int(1.4 * per_cell * area / cell**2) + 50


def _detect(view: View, contrast: float, budget: int) -> tuple[Floats, Greys]:
    """(N, 7) position, frame and strength of features in a fixed order, and descriptors."""
    import cv2

    sift = cv2.SIFT.create(
        nfeatures=budget, contrastThreshold=contrast, enable_precise_upscale=True
    )
    allowed = erode(view.mask, MARGIN).astype(np.uint8)
    keypoints, descriptors = sift.detectAndCompute(view.grey, allowed)
    if descriptors is None:
        return np.empty((0, 7)), np.empty((0, 128), np.float32)
    raw = np.array([(*k.pt, k.size, k.angle, k.response) for k in keypoints], np.float64)
    order = np.lexsort(raw.T)
    raw, descriptors = raw[order], descriptors[order]
    back = np.linalg.inv(view.matrix[:, :2])
    points = (raw[:, :2] - view.matrix[:, 2]) @ back.T
    angle, size = np.deg2rad(raw[:, 3]), raw[:, 2]
    cos, sin = size * np.cos(angle), size * np.sin(angle)
    turned = np.stack([np.stack([cos, -sin], -1), np.stack([sin, cos], -1)], -2)
    frames = (back @ turned).reshape(-1, 4)
    return np.column_stack([points, frames, raw[:, 4]]), descriptors


def _root(descriptors: Greys) -> Greys:
    """Hellinger descriptors as whole numbers."""
    total = np.maximum(descriptors.sum(axis=1, keepdims=True), 1e-6)
    rooted: Greys = np.rint(LENGTH * np.sqrt(descriptors / total)).astype(np.float32)
    return rooted


def _strongest(points: Floats, strength: Floats, cell: float, per_cell: int) -> Ints:
    """Choose the strongest points of each cell, in the order of cells."""
    if len(points) == 0:
        return np.empty(0, np.int64)
    place = np.floor(points / cell).astype(np.int64)
    place -= place.min(axis=0)
    key = place[:, 1] * (place[:, 0].max() + 1) + place[:, 0]
    order = np.lexsort((-strength, key))
    starts = np.r_[True, np.diff(key[order]) > 0]
    rank = np.arange(len(order))
    rank -= np.maximum.accumulate(np.where(starts, rank, 0))
    return order[rank < per_cell]
