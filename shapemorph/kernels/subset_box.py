"""How much of a subset, and of the box around a warped one, a picture shows."""

import numpy as np

from shapemorph.kernels.inner import inner
from shapemorph.kernels.vectors import LANES

MARGIN = 4  # px that the spline needs around a warped subset


@inner()
def pixels_inside(counts, left, top, right, bottom) -> int:  # type: ignore[no-untyped-def]
    """Count the good pixels in columns left ... right - 1 of rows top ... bottom - 1."""
    inner = counts[bottom, right] - counts[top, right] - counts[bottom, left]
    return int(inner + counts[top, left])


@inner()
def whole_box(counts, x, y, warp, radius) -> int:  # type: ignore[no-untyped-def]
    """Tell if the warped subset is inside (2), partly inside (1) or beyond reach (0)."""
    r, rr = float(radius), float(radius * radius)
    half_x = r * (abs(warp[1]) + abs(warp[2]))
    half_x += rr * (abs(warp[3]) + abs(warp[4]) + abs(warp[5]))
    half_y = r * (abs(warp[7]) + abs(warp[8]))
    half_y += rr * (abs(warp[9]) + abs(warp[10]) + abs(warp[11]))
    low_x, high_x = x + warp[0] - half_x, x + warp[0] + half_x
    low_y, high_y = y + warp[6] - half_y, y + warp[6] + half_y
    height, length = counts.shape[0] - 1, counts.shape[1] - 1
    if not (
        low_x >= MARGIN
        and low_y >= MARGIN
        and high_x < length - MARGIN - LANES
        and high_y < height - MARGIN
    ):
        return 0
    left, right = int(np.floor(low_x + 0.5)), int(np.floor(high_x + 0.5)) + 1
    top, bottom = int(np.floor(low_y + 0.5)), int(np.floor(high_y + 0.5)) + 1
    found = pixels_inside(counts, left, top, right, bottom)
    return 2 if found == (right - left) * (bottom - top) else 1
