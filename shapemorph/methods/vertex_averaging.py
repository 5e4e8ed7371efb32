"""What the noise of mesh vertices does to matches between their pictures."""

from collections.abc import Sequence

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.image import CalibratedImage

_PATTERN = 1.55
"""By how much an average over a pattern is noisier than one over its area: steep grey counts.

Measured: scatter of matches on synthetic pairs with 6 um of vertex noise."""
_AT_ONCE = 4096  # points, to bound memory


def averaged_noise(
    vertex_px: Floats, points_px: Floats, width_px: Floats, *, vertex_noise: float
) -> Floats:
    """Predict the tangential error of a match that noisy vertices cause.

    A flattened picture moves with its vertices: their noise along the surface distorts the
    pattern in the picture, and a position on the mesh, read through the same triangles,
    does not feel it. A match does: it follows the pattern, averaged over the subset. (The
    noise across the surface leaves the picture alone and enters the position in full.)

    Parameters
    ----------
    vertex_px : (V, 2)
        Vertices of the chart, px.
    points_px : (N, 2)
        px; NaN for lost points.
    width_px : (N,)
        Width of the subset in this picture, px.
    vertex_noise : float
        Standard deviation of one coordinate of a vertex, mm.

    Returns
    -------
    (N,)
        Standard deviation of one tangential component, mm on this surface; NaN where the
        point is.
    """
    count = count_in_squares(vertex_px, points_px, width_px)
    noise = _PATTERN * vertex_noise / np.sqrt(np.maximum(count, 1))
    lost = ~np.isfinite(points_px).all(axis=1) | ~np.isfinite(width_px)
    return np.where(lost, np.nan, noise)


def pattern_grain(
    reference: CalibratedImage, deformed: CalibratedImage, noise: Sequence[float]
) -> float:
    """Tell roughly what noisy vertices do to matches, before any is found.

    Parameters
    ----------
    reference, deformed : CalibratedImage
        Taken to show one piece of surface, evenly.
    noise : two floats
        Standard deviation of one coordinate of a vertex of either mesh, mm.

    Returns
    -------
    float
        Standard deviation of one component of a match, times the width of its subset, px^2
        of the reference picture.
    """
    areas = [float(side.image.mask.sum()) for side in (reference, deformed)]
    scales = (1.0, areas[0] / max(areas[1], 1.0))  # from px^2 of each picture to the first
    parts = [
        scale * sigma * side.chart.px_per_mm * np.sqrt(area / max(len(side.chart.vertex_px), 1))
        for side, sigma, area, scale in zip(
            (reference, deformed), noise, areas, scales, strict=True
        )
    ]
    return _PATTERN * float(np.hypot(*parts))


def leverage_of_cut_subsets(mask: Bools, points: Ints, width: int) -> Floats:
    """Say how much noisier a match is where the mask cuts its subset.

    A match with slopes knows the motion best at the centroid of what is left of its subset
    and carries it from there to the point: for noise that is alike all over the subset, the
    standard deviation grows by sqrt(1 + d^T M^-1 d), with the distance d and the second
    moments M about the centroid. That is 2 where half of the subset is left.

    Parameters
    ----------
    mask : (H, W) bool
    points : (N, 2) int
        px, (x, y); anywhere.
    width : int
        Of the subsets, px, odd.

    Returns
    -------
    (N,)
        1 or more; 1 where nothing is left.
    """
    radius = width // 2
    padded = np.pad(mask, radius)
    views = np.lib.stride_tricks.sliding_window_view(padded, (width, width))
    gain = np.ones(len(points))
    x, y = points.T
    known = np.flatnonzero((x >= 0) & (y >= 0) & (x < mask.shape[1]) & (y < mask.shape[0]))
    places = np.mgrid[-radius : radius + 1, -radius : radius + 1][::-1].reshape(2, -1).T
    terms = np.column_stack([np.ones(len(places)), places, places**2, places.prod(axis=1)])
    for some in np.array_split(known, 1 + len(known) // _AT_ONCE):
        left = views[y[some], x[some]].reshape(len(some), -1)
        cut = left.any(axis=1) & ~left.all(axis=1)
        gain[some[cut]] = _leverage(left[cut] @ terms)
    return gain


def _leverage(sums: Floats) -> Floats:
    """Gain from the sums of 1, x, y, x^2, y^2, xy over subsets, (N, 6)."""
    means = sums[:, 1:] / sums[:, :1]
    dx, dy = means[:, 0], means[:, 1]
    xx, yy, xy = means[:, 2] - dx**2 + 1 / 12, means[:, 3] - dy**2 + 1 / 12, means[:, 4] - dx * dy
    far = (yy * dx**2 - 2 * xy * dx * dy + xx * dy**2) / (xx * yy - xy**2)
    gain: Floats = np.sqrt(1 + far)
    return gain


def count_in_squares(scattered: Floats, centres: Floats, widths: Floats) -> Ints:
    """Count scattered points (V, 2) in squares about centres (N, 2), to the nearest whole px.

    Returns
    -------
    (N,)
        0 for squares that are not finite.
    """
    low = np.floor(scattered.min(axis=0)).astype(int)
    cells = np.floor(scattered).astype(int) - low
    size = cells.max(axis=0) + 1
    counts = np.bincount(cells[:, 1] * size[0] + cells[:, 0], minlength=int(size.prod()))
    summed = np.zeros((size[1] + 1, size[0] + 1), dtype=np.int64)
    summed[1:, 1:] = counts.reshape(size[1], size[0]).cumsum(axis=0).cumsum(axis=1)
    half = np.nan_to_num(widths)[:, None] / 2
    middle = np.nan_to_num(centres) - low
    left, top = np.clip(np.round(middle - half), 0, size).astype(int).T
    right, bottom = np.clip(np.round(middle + half), 0, size).astype(int).T
    found: Ints = (
        summed[bottom, right] - summed[top, right] - summed[bottom, left] + summed[top, left]
    )
    return found
