"""Loops of painting: which face covers a texel, what pattern its material carries."""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Bools, Floats, Greys, Ints


@njit(cache=True)
def cover(corners: Floats, height: int, width: int) -> Ints:
    """Find the face over each texel centre.

    Parameters
    ----------
    corners : (F, 3, 2)
        Corners (x, y) in texels, centres at integers.
    height, width : int

    Returns
    -------
    (H, W) int64
        Face, the last of several; -1 where there is none.
    """
    face = np.full((height, width), -1, dtype=np.int64)
    for f in range(corners.shape[0]):
        x0, y0 = corners[f, 0, 0], corners[f, 0, 1]
        x1, y1 = corners[f, 1, 0], corners[f, 1, 1]
        x2, y2 = corners[f, 2, 0], corners[f, 2, 1]
        area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
        if area == 0.0:
            continue
        top = max(int(np.ceil(min(y0, y1, y2))), 0)
        bottom = min(int(np.floor(max(y0, y1, y2))), height - 1)
        left = max(int(np.ceil(min(x0, x1, x2))), 0)
        right = min(int(np.floor(max(x0, x1, x2))), width - 1)
        for row in range(top, bottom + 1):
            for col in range(left, right + 1):
                second = ((col - x0) * (y2 - y0) - (x2 - x0) * (row - y0)) / area
                third = ((x1 - x0) * (row - y0) - (col - x0) * (y1 - y0)) / area
                if second >= -1e-9 and third >= -1e-9 and second + third <= 1.0 + 1e-9:
                    face[row, col] = f
    return face


@njit(cache=True)
def spread(filled: Bools, passes: int) -> Ints:
    """Find the filled texel from which each one around takes its value.

    Parameters
    ----------
    filled : (H, W) bool
    passes : int
        Texels that the filled region grows by, along rows and columns.

    Returns
    -------
    (H, W) int64
        Flat index of the source, itself where filled, -1 beyond reach.
    """
    height, width = filled.shape
    source = np.full((height, width), -1, dtype=np.int64)
    for row in range(height):
        for col in range(width):
            if filled[row, col]:
                source[row, col] = row * width + col
    for _ in range(passes):
        before = source.copy()
        for row in range(height):
            for col in range(width):
                if before[row, col] >= 0:
                    continue
                if row > 0 and before[row - 1, col] >= 0:
                    source[row, col] = before[row - 1, col]
                elif col > 0 and before[row, col - 1] >= 0:
                    source[row, col] = before[row, col - 1]
                elif row + 1 < height and before[row + 1, col] >= 0:
                    source[row, col] = before[row + 1, col]
                elif col + 1 < width and before[row, col + 1] >= 0:
                    source[row, col] = before[row, col + 1]
    return source


@njit(cache=True)
def speckle_brightness(
    x: float, y: float, blobs: Floats, origin: Floats, cell: Floats, edge: float
) -> float:
    """Brightness, 0 in a blob and 1 between blobs, at one material point."""
    rows, cols = blobs.shape[0], blobs.shape[1]
    across, down = (x - origin[0]) / cell[0], (y - origin[1]) / cell[1]
    col, row = int(np.floor(across)), int(np.floor(down))
    across, down = across - col, down - row
    col, row = col % cols, row % rows
    bright = 1.0
    for j in range(-1, 2):
        wrapped_row = (row + j) % rows
        for i in range(-1, 2):
            blob_col = col + i
            if blob_col < 0:
                blob_col += cols
            elif blob_col >= cols:
                blob_col -= cols
            dx = (across - i - blobs[wrapped_row, blob_col, 0]) * cell[0]
            dy = (down - j - blobs[wrapped_row, blob_col, 1]) * cell[1]
            radius = blobs[wrapped_row, blob_col, 2]
            outer, inner = radius + 0.5 * edge, radius - 0.5 * edge
            square = dx * dx + dy * dy
            if square >= outer * outer:
                continue
            if square <= inner * inner:
                return 0.0
            t = (np.sqrt(square) - inner) / edge
            bright *= t * t * (3.0 - 2.0 * t)
    return bright


@njit(cache=True, nogil=True, parallel=True)
def speckle_at(
    material: Floats, blobs: Floats, origin: Floats, cell: Floats, edge: float
) -> Floats:
    """Brightness (N,) of the speckle at material coordinates (N, 2); see `paint`."""
    bright = np.empty(material.shape[0])
    for k in prange(material.shape[0]):
        bright[k] = speckle_brightness(material[k, 0], material[k, 1], blobs, origin, cell, edge)
    return bright


@njit(cache=True)
def _material(nodes: Floats, second: float, third: float) -> tuple[float, float]:
    """Quadratic interpolation of material coordinates on a face of six nodes."""
    first = 1.0 - second - third
    w0, w1, w2 = first * (2 * first - 1), second * (2 * second - 1), third * (2 * third - 1)
    w3, w4, w5 = 4 * first * second, 4 * second * third, 4 * third * first
    x = w0 * nodes[0, 0] + w1 * nodes[1, 0] + w2 * nodes[2, 0]
    y = w0 * nodes[0, 1] + w1 * nodes[1, 1] + w2 * nodes[2, 1]
    x += w3 * nodes[3, 0] + w4 * nodes[4, 0] + w5 * nodes[5, 0]
    y += w3 * nodes[3, 1] + w4 * nodes[4, 1] + w5 * nodes[5, 1]
    return x, y


@njit(cache=True, nogil=True, parallel=True)
def paint(
    face: Ints,
    corners: Floats,
    nodes: Floats,
    blobs: Floats,
    origin: Floats,
    cell: Floats,
    edge: float,
    samples: int,
) -> tuple[Greys, Floats]:
    """Average the speckle over each texel, and say which material lies at its centre.

    Parameters
    ----------
    face : (H, W)
        Face that each texel belongs to, -1 for none; its plane is continued beyond it.
    corners : (F, 3, 2)
        Corners (x, y) in texels, centres at integers.
    nodes : (F, 6, 2)
        Material coordinates of corners and of the middles of edges 01, 12, 20, mm.
    blobs : (R, C, 3)
        For each cell of the lattice: position of its blob in the cell (0 to 1, x and y) and
        its radius, mm. The lattice repeats.
    origin, cell : (2,)
        Of the lattice, mm.
    edge : float
        Width over which a blob fades, mm.
    samples : int
        Samples along each side of a texel.

    Returns
    -------
    bright : (H, W) float32
        Mean brightness, 0 to 1; NaN without a face.
    material : (H, W, 2)
        Material coordinates at the centre, mm; NaN without a face.
    """
    height, width = face.shape
    bright = np.full((height, width), np.nan, dtype=np.float32)
    material = np.full((height, width, 2), np.nan)
    for row in prange(height):
        for col in range(width):
            f = face[row, col]
            if f < 0:
                continue
            x0, y0 = corners[f, 0, 0], corners[f, 0, 1]
            ax, ay = corners[f, 1, 0] - x0, corners[f, 1, 1] - y0
            bx, by = corners[f, 2, 0] - x0, corners[f, 2, 1] - y0
            area = ax * by - bx * ay
            total = 0.0
            for j in range(samples):
                for i in range(samples):
                    dx = col - x0 + (i + 0.5) / samples - 0.5
                    dy = row - y0 + (j + 0.5) / samples - 0.5
                    second, third = (dx * by - bx * dy) / area, (ax * dy - dx * ay) / area
                    x, y = _material(nodes[f], second, third)
                    total += speckle_brightness(x, y, blobs, origin, cell, edge)
            bright[row, col] = total / (samples * samples)
            dx, dy = col - x0, row - y0
            second, third = (dx * by - bx * dy) / area, (ax * dy - dx * ay) / area
            material[row, col, 0], material[row, col, 1] = _material(nodes[f], second, third)
    return bright, material
