"""PNG files for pictures that are written once and looked at: quick rather than small.

References
----------
ISO/IEC 15948:2004, Portable Network Graphics (PNG): Functional specification.
"""

import struct
import zlib

import numpy as np

_COLOUR_TYPES = {1: 0, 2: 4, 3: 2, 4: 6}  # channels: as the header names them
_INCHES_PER_METRE = 1 / 0.0254
_LEVEL = 3  # of zlib; 6 takes three times as long for a twentieth less


def png_bytes(
    pixels: np.ndarray[tuple[int, int, int], np.dtype[np.uint8]],
    *,
    per_inch: float | None = None,
) -> bytes:
    """Make the content of a PNG file, rows compressed as they are.

    Filters of rows are what makes encoders slow; flat colours compress as well without.
    Python's lock is free while it compresses.

    Parameters
    ----------
    pixels : (H, W, C) uint8
        First row on top; grey (C = 1), grey and opacity (2), RGB (3) or RGBA (4).
    per_inch : float, optional
        Pixels per inch that programs should show it at.
    """
    height, width, channels = pixels.shape
    rows = np.zeros((height, 1 + width * channels), np.uint8)  # 0: no filter
    rows[:, 1:] = pixels.reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, _COLOUR_TYPES[channels], 0, 0, 0)
    chunks = [_chunk(b"IHDR", header)]
    if per_inch is not None:
        density = round(per_inch * _INCHES_PER_METRE)
        chunks.append(_chunk(b"pHYs", struct.pack(">IIB", density, density, 1)))
    chunks += [_chunk(b"IDAT", zlib.compress(rows.data, _LEVEL)), _chunk(b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def _chunk(name: bytes, content: bytes) -> bytes:
    """Length, name, content and checksum."""
    return (
        struct.pack(">I", len(content))
        + name
        + content
        + struct.pack(">I", zlib.crc32(content, zlib.crc32(name)))
    )
