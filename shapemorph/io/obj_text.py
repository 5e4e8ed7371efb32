"""The statements of an OBJ file as arrays."""

import re
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.io.mtl import decode_text
from shapemorph.io.text_numbers import NotANumberError, parse_corners, parse_lines
from shapemorph.kernels.number_text import Bytes, lines_with

_COMMENT = ord("#")


@dataclass(frozen=True, slots=True, eq=False)
class ObjLines:
    """An OBJ file cut into lines.

    Attributes
    ----------
    name : str
    text : bytes
        Ends with a line break; lines begin with their keyword.
    start, end : (L,) int64
        First byte of each line, and its line break.
    """

    name: str
    text: bytes
    start: Ints
    end: Ints

    @property
    def data(self) -> Bytes:
        """The text as numbers (B,)."""
        return np.frombuffer(self.text, dtype=np.uint8)

    def rows(self, keyword: bytes) -> Ints:
        """Lines that begin with a keyword and a blank."""
        rows: Ints = lines_with(
            self.data, self.start, self.end, np.frombuffer(keyword, dtype=np.uint8)
        )
        return rows

    def statement(self, row: int, keyword: str) -> str:
        """Return what follows the keyword on one line."""
        return decode_text(self.text[self.start[row] : self.end[row]])[len(keyword) :].strip()

    def problem(self, row: int, message: str) -> DataError:
        """Make an error that names a line."""
        return DataError(f"{self.name}, line {row + 1}: {message}")


@dataclass(frozen=True, slots=True, eq=False)
class Polygons:
    """Faces as the file has them, corner after corner.

    Attributes
    ----------
    vertex, uv : (N,) int64
        Rows of the vertices and of the texture coordinates; uv is -1 where there is none.
    sizes : (P,) int64
        Corners of each polygon.
    line : (P,) int64
        Line of each polygon.
    """

    vertex: Ints
    uv: Ints
    sizes: Ints
    line: Ints


def cut_lines(data: bytes, name: str) -> ObjLines:
    """Cut a file into lines: line breaks of every system, continuations joined."""
    if b"\0" in data[: 1 << 20]:
        raise DataError(f"{name}: expected the text of an OBJ file, got binary data")
    text = data.removeprefix(b"\xef\xbb\xbf")
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if b"\\\n" in text:
        text = text.replace(b"\\\n", b" ")
    if not text.endswith(b"\n"):
        text += b"\n"
    start, end = _line_ends(text)
    first = np.frombuffer(text, dtype=np.uint8)[start]
    if ((first == ord(" ")) | (first == ord("\t"))).any():
        text = re.sub(rb"(?m)^[ \t]+", b"", text)
        start, end = _line_ends(text)
    return ObjLines(name, text, start, end)


def read_vertices(lines: ObjLines) -> tuple[Floats, Floats | None]:
    """Positions (V, 3), and colours (V, 3) if every vertex has one."""
    table, counts = _table(lines, b"v", fewest=3)
    if len(counts) == 0:
        raise DataError(
            f"{lines.name}: expected an OBJ file with vertices (lines 'v x y z'), got none"
        )
    first = np.cumsum(counts) - counts
    positions = table[first[:, None] + np.arange(3)]
    if counts.min() < 6:
        return positions, None
    return positions, table[first[:, None] + np.arange(3, 6)]


def read_texture_coordinates(lines: ObjLines) -> Floats:
    """Texture coordinates (T, 2); a missing second one is 0."""
    table, counts = _table(lines, b"vt", fewest=1)
    if len(counts) and counts.min() == 1:
        table = np.append(table, 0.0)
    first = np.cumsum(counts) - counts
    uv: Floats = table[np.minimum(first[:, None] + np.arange(2), max(len(table) - 1, 0))]
    uv[counts == 1, 1] = 0.0
    return uv


def read_polygons(lines: ObjLines) -> Polygons:
    """Faces with indices resolved to rows; lines with less than three corners are left out."""
    rows = lines.rows(b"f")
    try:
        vertex, uv, sizes = parse_corners(
            lines.data, lines.start[rows] + 1, lines.end[rows], comment=_COMMENT
        )
    except NotANumberError as error:
        message = f"expected corners v, v/vt, v//vn or v/vt/vn, got {error.token!r}"
        raise lines.problem(int(rows[error.line]), message) from None
    line = np.repeat(rows, sizes)
    kept = np.repeat(sizes >= 3, sizes)
    return Polygons(
        _resolved(lines, b"v", vertex, line)[kept],
        _resolved(lines, b"vt", uv, line)[kept],
        sizes[sizes >= 3],
        rows[sizes >= 3],
    )


def _line_ends(text: bytes) -> tuple[Ints, Ints]:
    """First byte of every line, and its line break."""
    end = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n"))
    return np.r_[0, end[:-1] + 1], end


def _table(lines: ObjLines, keyword: bytes, fewest: int) -> tuple[Floats, Ints]:
    """Numbers on all lines of one keyword, and how many on each."""
    rows = lines.rows(keyword)
    if len(rows) == 0:
        return np.zeros(0), np.zeros(0, dtype=np.int64)
    try:
        begin = lines.start[rows] + len(keyword)
        values, counts = parse_lines(lines.data, begin, lines.end[rows], comment=_COMMENT)
    except NotANumberError as error:
        message = f"expected numbers after {keyword.decode()}, got {error.token!r}"
        raise lines.problem(int(rows[error.line]), message) from None
    short = np.flatnonzero(counts < fewest)
    if len(short):
        row = int(short[0])
        message = f"expected {fewest} or more numbers after {keyword.decode()}, got {counts[row]}"
        raise lines.problem(int(rows[row]), message)
    return values, counts


def _resolved(lines: ObjLines, keyword: bytes, written: Ints, line: Ints) -> Ints:
    """Turn numbers as written (from 1, or backwards from -1) into rows; -1 for a missing vt."""
    defined = lines.rows(keyword)
    row = written - 1
    backwards = np.flatnonzero(written < 0)
    row[backwards] = np.searchsorted(defined, line[backwards]) + written[backwards]
    lowest = -1 if keyword == b"vt" else 0
    wrong = np.flatnonzero((row < lowest) | (row >= len(defined)) | ((written < 0) & (row < 0)))
    if len(wrong):
        got = int(written[wrong[0]])
        message = f"expected {keyword.decode()} numbers from 1 to {len(defined)}, got {got}"
        raise lines.problem(int(line[wrong[0]]), message)
    return row
