"""Size of the speckle of a picture: width of its autocorrelation at half height."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys, Ints

TILE = 64  # px
COVERED = 0.7  # share of a tile that must lie inside the mask
MOST_TILES = 36
LEAST_CONTRAST = 2.0 / 255.0  # standard deviation of grey in a tile that shows a pattern
DIRECTIONS = 8
STEP = 0.25  # px along a direction


def choose_tiles(mask: Bools) -> Ints:
    """Pick tiles of 64 x 64 px that lie mostly inside a mask, spread over it.

    Returns
    -------
    (K, 2)
        Row and column of each tile's first pixel; the K <= 36 do not depend on the grey.
    """
    import cv2

    height, width = mask.shape
    rows = np.arange(0, max(height - TILE, 0) + 1, TILE // 2)
    cols = np.arange(0, max(width - TILE, 0) + 1, TILE // 2)
    total = cv2.integral(mask.view(np.uint8), sdepth=cv2.CV_32S)
    low, high = np.minimum(rows + TILE, height), np.minimum(cols + TILE, width)
    inside = (
        total[np.ix_(low, high)]
        - total[np.ix_(rows, high)]
        - total[np.ix_(low, cols)]
        + total[np.ix_(rows, cols)]
    )
    found = np.argwhere(inside >= COVERED * TILE * TILE)
    corners = np.stack([rows[found[:, 0]], cols[found[:, 1]]], axis=1)
    chosen = np.unique(np.linspace(0, len(corners) - 1, MOST_TILES).round().astype(int))
    tiles: Ints = corners[chosen] if len(corners) else corners
    return tiles


def tile_widths(grey: Greys, mask: Bools, tiles: Ints) -> Floats:
    """Measure the size of a speckle in tiles of a picture.

    Parameters
    ----------
    grey : (H, W)
    mask : (H, W)
        Grey outside it is not looked at.
    tiles : (K, 2)
        From :func:`choose_tiles`.

    Returns
    -------
    (K,)
        Diameter of the disk as large as the region where the autocorrelation exceeds
        one half, px; NaN where the tile shows no pattern, and the tile's size where the
        autocorrelation stays above one half.
    """
    if len(tiles) == 0:
        return np.zeros(0)
    some_grey = np.stack([grey[r : r + TILE, c : c + TILE] for r, c in tiles]).astype(np.float64)
    inside = np.stack([mask[r : r + TILE, c : c + TILE] for r, c in tiles]).astype(np.float64)
    correlation, contrast = _autocorrelate(some_grey, inside)
    radius = _half_radius(correlation)
    widths: Floats = 2.0 * np.sqrt((radius**2).mean(axis=1))
    widths[contrast < LEAST_CONTRAST] = np.nan
    return widths


def _autocorrelate(grey: Floats, inside: Floats) -> tuple[Floats, Floats]:
    """Normalised autocorrelation of masked tiles, lag zero at the centre, and contrast."""
    axes = (1, 2)
    if inside.all():
        inside = inside[:1]  # one stands for all
    count = inside.sum(axis=axes, keepdims=True)
    centred = (grey - (grey * inside).sum(axis=axes, keepdims=True) / count) * inside
    variance = (centred**2).sum(axis=axes) / count[:, 0, 0]
    size = (2 * grey.shape[1], 2 * grey.shape[2])
    power = np.abs(np.fft.rfft2(centred, size, axes=axes)) ** 2
    overlap = np.abs(np.fft.rfft2(inside, size, axes=axes)) ** 2
    products = np.fft.irfft2(power, size, axes=axes)
    pairs = np.maximum(np.fft.irfft2(overlap, size, axes=axes), 1.0)
    scale = np.maximum(variance, 1e-30)[:, None, None]
    return np.fft.fftshift(products / pairs / scale, axes=axes), np.sqrt(variance)


def _half_radius(correlation: Floats) -> Floats:
    """(K, directions) distance at which each autocorrelation first falls below one half."""
    height, width = correlation.shape[1:]
    angle = np.arange(DIRECTIONS) * np.pi / DIRECTIONS
    reach = np.arange(STEP, min(height, width) / 4, STEP)
    rows = height // 2 + np.sin(angle)[:, None] * reach
    cols = width // 2 + np.cos(angle)[:, None] * reach
    values = _between(correlation, rows, cols)
    below = values < 0.5
    first = np.where(below.any(axis=2), below.argmax(axis=2), len(reach) - 1)
    after = np.take_along_axis(values, first[..., None], axis=2)[..., 0]
    before = np.take_along_axis(values, np.maximum(first - 1, 0)[..., None], axis=2)[..., 0]
    before = np.where(first > 0, before, 1.0)
    part = np.clip((before - 0.5) / np.maximum(before - after, 1e-12), 0.0, 1.0)
    radius: Floats = reach[first] - STEP + STEP * part
    return radius


def _between(values: Floats, rows: Floats, cols: Floats) -> Floats:
    """Bilinear interpolation in each of a stack of pictures."""
    row, col = np.floor(rows).astype(np.int64), np.floor(cols).astype(np.int64)
    down, right = rows - row, cols - col
    upper = values[:, row, col] * (1.0 - right) + values[:, row, col + 1] * right
    lower = values[:, row + 1, col] * (1.0 - right) + values[:, row + 1, col + 1] * right
    return np.asarray(upper * (1.0 - down) + lower * down)


def speckle_size(grey: Greys, mask: Bools) -> float:
    """Measure the size of a speckle of a picture, px.

    Coarse patterns are measured on a reduced picture.

    Returns
    -------
    float
        Median over tiles of the width of the autocorrelation at half height; NaN
        where there is no pattern, or no room for a tile.
    """
    reduction = 1
    best = np.nan
    while min(grey.shape) >= TILE:
        widths = tile_widths(grey, mask, choose_tiles(mask))
        if not np.isfinite(widths).any():
            return float(best)
        best = float(np.nanmedian(widths)) * reduction
        if best <= TILE / 5 * reduction:
            return best
        grey, mask = _halve(grey, mask)
        reduction *= 2
    return float(best)


def _halve(grey: Greys, mask: Bools) -> tuple[Greys, Bools]:
    """Average 2 x 2 px; a pixel counts where three of the four did."""
    height, width = (2 * (size // 2) for size in grey.shape)
    blocks = (height // 2, 2, width // 2, 2)
    count = mask[:height, :width].reshape(blocks).sum(axis=(1, 3))
    total = np.where(mask, grey, 0)[:height, :width].reshape(blocks).sum(axis=(1, 3))
    return (total / np.maximum(count, 1)).astype(np.float32), count >= 3
