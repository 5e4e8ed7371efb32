"""The elements of a PLY file as columns, whatever its encoding."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from shapemorph.core.arrays import Ints
from shapemorph.core.errors import DataError
from shapemorph.io.mtl import decode_text
from shapemorph.io.text_numbers import NotANumberError, parse_floats

_LONGEST_HEADER = 1 << 20
_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float32": "f4",
    "float64": "f8",
}
_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True, slots=True)
class PlyProperty:
    """One property; `count_type` is None for a plain number and set for a list."""

    name: str
    item_type: np.dtype[Any]
    count_type: np.dtype[Any] | None


@dataclass(frozen=True, slots=True)
class PlyElement:
    """One element of the header."""

    name: str
    count: int
    properties: tuple[PlyProperty, ...]


@dataclass(frozen=True, slots=True)
class PlyHeader:
    """What a PLY file says of itself; `body` is the first byte after the header."""

    is_text: bool
    elements: tuple[PlyElement, ...]
    comments: tuple[str, ...]
    body: int
    lines: int


@dataclass(frozen=True, slots=True, eq=False)
class Column:
    """One property of all rows.

    Attributes
    ----------
    values : (N,) any type
        Items one after the other.
    counts : (R,) int64
        Items of each row: ones for a plain number.
    """

    values: NDArray[Any]
    counts: Ints


Table = dict[str, Column]


@dataclass(frozen=True, slots=True, eq=False)
class _TextBody:
    """Numbers of an ASCII body; the unit of places and sizes is one number."""

    numbers: NDArray[np.float64]

    @property
    def length(self) -> int:
        return len(self.numbers)

    def size(self, kind: np.dtype[Any]) -> int:
        return 1 if kind.itemsize else 0

    def integer(self, place: int, kind: np.dtype[Any]) -> int:  # noqa: ARG002 one interface
        value = float(self.numbers[place])
        return int(value) if value.is_integer() else -1

    def take(self, places: Ints, count: int, kind: np.dtype[Any]) -> NDArray[Any]:
        taken = sliding_window_view(self.numbers, count)[places] if count else np.zeros((0, 0))
        if np.issubdtype(kind, np.integer):
            limits = np.iinfo(kind)
            return np.clip(np.nan_to_num(taken), limits.min, limits.max).astype(kind)
        with np.errstate(over="ignore"):  # too large for the type that the header names: inf
            return taken.astype(kind)


@dataclass(frozen=True, slots=True, eq=False)
class _ByteBody:
    """A binary body; the unit of places and sizes is one byte."""

    data: NDArray[np.uint8]

    @property
    def length(self) -> int:
        return len(self.data)

    def size(self, kind: np.dtype[Any]) -> int:
        return kind.itemsize

    def integer(self, place: int, kind: np.dtype[Any]) -> int:
        return int(self.data[place : place + kind.itemsize].view(kind)[0])

    def take(self, places: Ints, count: int, kind: np.dtype[Any]) -> NDArray[Any]:
        if count == 0:
            return np.zeros((len(places), 0), dtype=kind)
        window = sliding_window_view(self.data, count * kind.itemsize)[places]
        return np.ascontiguousarray(window).view(kind)


_Body = _TextBody | _ByteBody


def read_elements(data: bytes, name: str) -> tuple[PlyHeader, dict[str, Table]]:
    """Read all elements of a PLY file.

    Raises
    ------
    DataError
        If the header is damaged or promises more than the file holds.
    """
    header = _header(data, name)
    body = (
        _text_body(data, header, name)
        if header.is_text
        else _ByteBody(np.frombuffer(data, dtype=np.uint8)[header.body :])
    )
    tables: dict[str, Table] = {}
    place = 0
    for element in header.elements:
        tables[element.name], place = _table(body, element, place, name)
    return header, tables


def _header(data: bytes, name: str) -> PlyHeader:
    end = data.find(b"end_header", 0, _LONGEST_HEADER)
    if not data.startswith(b"ply") or end < 0:
        raise DataError(f"{name}: expected a PLY file (ply ... end_header), got something else")
    after = data.find(b"\n", end)
    lines = decode_text(data[:end]).replace("\r\n", "\n").replace("\r", "\n").split("\n")
    statements = [line.strip() for line in lines]
    comments = [s[len("comment") :].strip() for s in statements if s.startswith("comment")]
    formats = [s.split()[1:2] for s in statements if s.startswith("format")]
    encoding = formats[0][0] if formats and formats[0] else "nothing"
    if encoding not in _ORDERS:
        raise DataError(f"{name}: expected format {', '.join(_ORDERS)}, got {encoding[:40]!r}")
    elements: list[PlyElement] = []
    for number, line in enumerate(statements, start=1):
        try:
            if line.startswith("element"):
                _, kind, count = line.split()
                elements.append(PlyElement(kind, _count(count), ()))
            elif line.startswith("property"):
                elements[-1] = _with_property(elements[-1], line.split(), _ORDERS[encoding])
        except (IndexError, KeyError, ValueError):
            raise DataError(
                f"{name}, line {number}: expected a statement of a PLY header, got {line[:60]!r}"
            ) from None
    body = len(data) if after < 0 else after + 1
    return PlyHeader(encoding == "ascii", tuple(elements), tuple(comments), body, len(lines))


def _count(word: str) -> int:
    count = int(word)
    if count < 0:
        raise ValueError(word)
    return count


def _with_property(element: PlyElement, words: list[str], order: str) -> PlyElement:
    if words[1] == "list":
        count_type: np.dtype[Any] | None = np.dtype(order + _TYPES[words[2]])
        item_type, name = np.dtype(order + _TYPES[words[3]]), words[4]
        if count_type is not None and count_type.kind == "f":
            raise ValueError(words[2])
    else:
        count_type, item_type, name = None, np.dtype(order + _TYPES[words[1]]), words[2]
    added = PlyProperty(name, item_type, count_type)
    return PlyElement(element.name, element.count, (*element.properties, added))


def _text_body(data: bytes, header: PlyHeader, name: str) -> _TextBody:
    block = data[header.body :]
    try:
        return _TextBody(parse_floats(block)[0])
    except NotANumberError as error:
        raise DataError(
            f"{name}, line {header.lines + 1 + error.line}: expected numbers, got {error.token!r}"
        ) from None


def _table(body: _Body, element: PlyElement, place: int, name: str) -> tuple[Table, int]:
    """Columns of one element, and where the next begins."""
    if element.count == 0 or not element.properties:
        return {p.name: _empty(p) for p in element.properties}, place
    least = sum(body.size(p.count_type or p.item_type) for p in element.properties)
    if place + element.count * least > body.length:
        raise _too_short(element, name)
    starts, counts, end = _rows(body, element, place, name)
    columns: Table = {}
    for k, item in enumerate(element.properties):
        skip = body.size(item.count_type) if item.count_type is not None else 0
        columns[item.name] = _column(body, item, starts[:, k] + skip, counts[:, k])
    return columns, end


def _empty(item: PlyProperty) -> Column:
    return Column(np.zeros(0, dtype=item.item_type.newbyteorder("=")), np.zeros(0, dtype=np.int64))


def _too_short(element: PlyElement, name: str) -> DataError:
    return DataError(
        f"{name}: expected {element.count} rows of element {element.name[:40]}, got a file that "
        "ends before: it is truncated, copy or export it again"
    )


def _rows(body: _Body, element: PlyElement, place: int, name: str) -> tuple[Ints, Ints, int]:
    """Place and number of items of every property of every row, and the end of the last."""
    starts, counts, end = _walk(body, element, place, 1, name)
    stride = end - place
    row = np.arange(element.count)[:, None]
    if place + stride * element.count <= body.length:
        everywhere = starts + stride * row
        if _counts_hold(body, element, everywhere, counts[0]):
            return everywhere, np.tile(counts, (element.count, 1)), place + stride * element.count
    return _walk(body, element, place, element.count, name)


def _counts_hold(body: _Body, element: PlyElement, starts: Ints, counts: Ints) -> bool:
    """Whether all rows have lists as long as those of the first."""
    return all(
        (body.take(starts[:, k], 1, item.count_type)[:, 0] == counts[k]).all()
        for k, item in enumerate(element.properties)
        if item.count_type is not None
    )


def _walk(
    body: _Body, element: PlyElement, place: int, rows: int, name: str
) -> tuple[Ints, Ints, int]:
    """Follow the lists row by row, from the first one on."""
    layout = [
        (
            item.count_type,
            body.size(item.count_type) if item.count_type is not None else 0,
            body.size(item.item_type),
        )
        for item in element.properties
    ]
    starts = np.empty((rows, len(layout)), dtype=np.int64)
    counts = np.ones((rows, len(layout)), dtype=np.int64)
    for row in range(rows):
        for k, (count_type, skip, size) in enumerate(layout):
            starts[row, k] = place
            if place + (skip or size) > body.length:
                raise _too_short(element, name)
            count = 1 if count_type is None else body.integer(place, count_type)
            if count < 0:
                raise DataError(f"{name}: expected a list length, got {count}: the file is damaged")
            place += skip + count * size
            if place > body.length:
                raise _too_short(element, name)
            counts[row, k] = count
    return starts, counts, place


def _column(body: _Body, item: PlyProperty, places: Ints, counts: Ints) -> Column:
    """Gather the items of one property, rows of equal length at a time."""
    native = item.item_type.newbyteorder("=")
    sizes = np.unique(counts)
    if len(sizes) == 1:
        values = body.take(places, int(sizes[0]), item.item_type).ravel()
        return Column(values.astype(native, copy=False), counts)
    first = np.cumsum(counts) - counts
    gathered = np.empty(int(counts.sum()), dtype=native)
    for size in sizes[sizes > 0]:
        rows = counts == size
        slots = first[rows][:, None] + np.arange(size)
        gathered[slots] = body.take(places[rows], int(size), item.item_type)
    return Column(gathered, counts)
