"""Landmarks: named points that a user has identified on both shapes."""

import csv
import io
import math
from pathlib import Path

import numpy as np

from shapemorph.core.errors import DataError
from shapemorph.core.landmarks import Landmarks
from shapemorph.io.images import read_bytes
from shapemorph.io.mtl import decode_text

COLUMNS = ("name", "ref_x", "ref_y", "ref_z", "def_x", "def_y", "def_z")


def read_landmarks(path: Path, *, reference_scale: float, deformed_scale: float) -> Landmarks:
    """Read a CSV of landmarks.

    Parameters
    ----------
    path : Path
        With the header ``name,ref_x,ref_y,ref_z,def_x,def_y,def_z``; empty lines and lines
        that begin with # do not count.
    reference_scale, deformed_scale : float
        mm per unit of the two mesh files, in whose frames the positions are.

    Raises
    ------
    DataError
        If the file is missing or a value is; names line and column.
    """
    rows = _rows(path)
    _check_header(path.name, rows)
    names: list[str] = []
    positions = []
    for line, cells in rows[1:]:
        if len(cells) != len(COLUMNS):
            raise DataError(
                f"{path.name}, line {line}: expected {len(COLUMNS)} columns ({','.join(COLUMNS)}), "
                f"got {len(cells)}"
            )
        if cells[0] in names:
            raise DataError(
                f"{path.name}, line {line}, column name: {cells[0]!r} is there twice: rename one"
            )
        names.append(cells[0])
        positions.append([_number(path.name, line, k, cells[k]) for k in range(1, len(COLUMNS))])
    if not names:
        raise DataError(f"{path.name}: expected landmarks below the header, got none")
    table = np.array(positions)
    return Landmarks(tuple(names), table[:, :3] * reference_scale, table[:, 3:] * deformed_scale)


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Line numbers and cells of all lines that count."""
    text = decode_text(read_bytes(path, what="landmarks"))
    try:
        reader = csv.reader(io.StringIO(text, newline=""), skipinitialspace=True)
        table = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except csv.Error as error:
        raise DataError(f"{path.name}: expected a CSV file, got something else ({error})") from None
    return [(line, row) for line, row in table if any(row) and not row[0].startswith("#")]


def _check_header(name: str, rows: list[tuple[int, list[str]]]) -> None:
    header = tuple(cell.lower() for cell in rows[0][1]) if rows else ()
    if header != COLUMNS:
        raise DataError(
            f"{name}, line {rows[0][0] if rows else 1}: expected the header {','.join(COLUMNS)}, "
            f"got {','.join(header)[:80] or 'nothing'}"
        )


def _number(name: str, line: int, column: int, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise DataError(
            f"{name}, line {line}, column {COLUMNS[column]}: expected a number, got {cell[:40]!r}"
        )
    return value
