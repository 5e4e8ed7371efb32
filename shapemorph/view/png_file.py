"""PNG files, written fast: each row as what it adds to the row above."""

import struct
import zlib

import numpy as np

from shapemorph.view.window import Pixels

SIGNATURE = b"\x89PNG\r\n\x1a\n"
UP = 2
"""The filter of a row that holds differences to the row above (PNG specification, 9.2)."""
MEMORY = 9
"""Of zlib, the most."""
INCH = 0.0254
"""m."""


def png_content(pixels: Pixels, dpi: float, level: int) -> bytes:
    """Write an RGB picture as PNG.

    Libraries try all five filters on every row, which takes twice the time for files of the
    same size where pictures are drawn and rendered.

    Parameters
    ----------
    pixels : (H, W, 3) uint8
    dpi : float
        Pixels per inch in print.
    level : int
        Of zlib, 1 (fast) to 9 (small).
    """
    height, width = pixels.shape[:2]
    flat = pixels.reshape(height, 3 * width)
    rows = np.empty((height, 1 + 3 * width), np.uint8)
    rows[:, 0] = UP
    rows[0, 1:] = flat[0]
    np.subtract(flat[1:], flat[:-1], out=rows[1:, 1:])
    packer = zlib.compressobj(level, zlib.DEFLATED, zlib.MAX_WBITS, MEMORY)
    per_metre = round(dpi / INCH)
    return b"".join(
        (
            SIGNATURE,
            _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)),
            _chunk(b"pHYs", struct.pack(">IIB", per_metre, per_metre, 1)),
            _chunk(b"IDAT", packer.compress(rows.data) + packer.flush()),
            _chunk(b"IEND", b""),
        )
    )


def _chunk(kind: bytes, content: bytes) -> bytes:
    checked = zlib.crc32(kind + content)
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", checked)
