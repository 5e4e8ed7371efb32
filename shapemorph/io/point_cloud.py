"""Point clouds with grey: tables of X, Y, Z, grey, and the mesh through the points."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.io.file_mesh import FileMesh, bare_mesh, check_positions
from shapemorph.io.greys import grey_of
from shapemorph.io.images import read_bytes
from shapemorph.io.mtl import decode_text
from shapemorph.io.text_numbers import NotANumberError, parse_floats
from shapemorph.methods.cleaning import weld
from shapemorph.methods.meshing import mesh_points

_STEEPEST = np.deg2rad(75.0)
_REACH = 3.0
_LEAST_USED = 0.98
_SAME_POINT = 1e-6  # of the diagonal

_COMMENTS = ("#", "//", "%")
_GREY_NAMES = ("grey", "gray", "intensity", "value", "brightness", "luminance", "i", "g")
_COLOUR_NAMES = (("r", "g", "b"), ("red", "green", "blue"))


def read_table(path: Path, channel: str = "luma") -> FileMesh:
    """Read a table of points X, Y, Z, grey or X, Y, Z, R, G, B and mesh it.

    Columns are separated by commas, semicolons (then decimals may have a comma), tabs or
    blanks; a header line is optional. Grey runs from 0 to 1, 255 or 65535 by its range.

    Raises
    ------
    DataError
        If the file is no such table; names the line.
    """
    table, names = _numbers(decode_text(read_bytes(path, what="point cloud")), path.name)
    columns, note = _columns(names, table.shape[1], path.name)
    used = table[:, columns]
    grey_columns = used[:, 3:]
    known = np.asarray(np.isfinite(used).all(axis=1))
    stored = grey_columns[known]
    used_grey = stored if stored.shape[1] == 3 else stored[:, 0]
    grey = grey_of(used_grey, name=path.name, channel=channel)
    mesh = mesh_of_points(used[known, :3], grey, name=path.name, file_format="table of points")
    lost = int((~known).sum())
    gaps = [f"{lost} of {len(known)} points without a value were left out"] if lost else []
    return mesh.noted(*note, *gaps)


def mesh_of_points(points: Floats, grey: Floats, *, name: str, file_format: str) -> FileMesh:
    """Mesh a cloud of points (N, 3) with grey (N,); points that are not finite are left out."""
    finite = np.isfinite(points).all(axis=1)
    points, grey = points[finite], grey[finite]
    if len(points) < 4:
        raise DataError(f"{name}: expected a cloud of at least 4 points, got {len(points)}")
    check_positions(points, np.arange(len(points)), name=name)
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    kept, _ = weld(points, tolerance=_SAME_POINT * diagonal)
    try:
        meshed = mesh_points(points[kept], steepest=_STEEPEST, reach=_REACH, least_used=_LEAST_USED)
    except DataError as error:
        raise DataError(f"{name}: {error}") from None
    mesh = bare_mesh(points[kept], meshed.faces, file_format=file_format)
    notes = [f"{int((~finite).sum())} points were not finite"] if not finite.all() else []
    if len(kept) < len(points):
        notes.append(f"{len(points) - len(kept)} points lie on another and were left out")
    coloured = mesh.coloured(grey[kept][meshed.faces]).noted(*notes)
    return replace(coloured, method=meshed.method, grey_source="point cloud")


def _numbers(text: str, name: str) -> tuple[Floats, list[str]]:
    """Table (N, C) of numbers, and the names of its columns if it has a header."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    number = [k for k, line in enumerate(lines) if _is_data(line)]
    if not number or "\0" in text:
        raise DataError(f"{name}: expected lines X,Y,Z,grey, got none")
    if len(number) > 1 and lines[number[0]].strip().isdigit():
        number = number[1:]  # a count of points
    separator = _separator(lines[number[-1]])
    rows = _spaced("\n".join(lines[k] for k in number), separator).split("\n")
    header: list[str] = []
    if not _all_numbers(rows[0]):
        header = [_plain(cell) for cell in _cells(lines[number[0]], separator)]
        rows, number = rows[1:], number[1:]
    if not rows:
        raise DataError(f"{name}: expected points below the header, got none")
    try:
        values, counts = parse_floats("\n".join(rows).encode())
    except NotANumberError as error:
        raise DataError(
            f"{name}, line {number[error.line] + 1}: expected numbers, got {error.token!r}"
        ) from None
    uneven = np.flatnonzero(counts != counts[0])
    if len(uneven):
        raise DataError(
            f"{name}, line {number[int(uneven[0])] + 1}: expected {counts[0]} numbers as on the "
            f"first line, got {counts[uneven[0]]}"
        )
    return values.reshape(len(rows), -1), header


def _is_data(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith(_COMMENTS)


def _separator(line: str) -> str:
    """Tell what separates columns from a line of numbers."""
    return ";" if ";" in line else "," if "," in line else " "


def _spaced(text: str, separator: str) -> str:
    """Columns with blanks between them; an empty one is an error later on."""
    if separator == " ":
        return text
    if separator == ";":
        text = text.replace(",", ".")
    text = re.sub(rf"(?m){separator}[ \t]*$", "", text)
    text = re.sub(rf"(?m)(^|(?<={separator}))[ \t]*(?={separator})", "(empty)", text)
    return text.replace(separator, " ")


def _cells(line: str, separator: str) -> list[str]:
    return line.split() if separator == " " else line.rstrip(f"{separator} \t").split(separator)


def _all_numbers(row: str) -> bool:
    try:
        return bool([float(cell) for cell in row.split()])
    except ValueError:
        return False


def _plain(cell: str) -> str:
    """Name of a column without quotes and unit."""
    name = re.sub(r"[\[(].*?[\])]", "", cell).strip().strip("\"'").strip().lower()
    return re.sub(r"_(mm|um|cm|m|in)$", "", name)


def _columns(names: list[str], count: int, name: str) -> tuple[list[int], list[str]]:
    """Columns of x, y, z and of grey or colour; by name, else by number."""
    place = {column: k for k, column in enumerate(names)}
    if names and len(names) == count and all(axis in place for axis in "xyz"):
        choices = [*_COLOUR_NAMES, *((grey,) for grey in _GREY_NAMES)]
        found = next((c for c in choices if all(part in place for part in c)), None)
        if found is not None:
            return [place[column] for column in ("x", "y", "z", *found)], []
    if count in (4, 6):
        note = [f"columns {', '.join(names)[:80]} taken by their order"] if names else []
        return list(range(count)), note
    raise DataError(
        f"{name}: expected columns X,Y,Z,grey or X,Y,Z,R,G,B, got {count} columns"
        f"{' (' + ', '.join(names)[:80] + ')' if names else ''}: name or reorder them"
    )
