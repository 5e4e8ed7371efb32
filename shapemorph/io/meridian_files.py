"""Meridians of surfaces of revolution as CSV files."""

import csv
import io
import math
from pathlib import Path

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.io.images import read_bytes
from shapemorph.io.mtl import decode_text

COLUMNS = ("r", "z")


def read_meridian(path: Path, *, scale: float) -> Floats:
    """Read a CSV of points along a meridian, from a measurement or a finite-element result.

    Parameters
    ----------
    path : Path
        With the header ``r,z``; points in order, from the inside outward; empty lines and
        lines that begin with # do not count.
    scale : float
        mm per unit of the file.

    Returns
    -------
    (K, 2)
        r >= 0 and z, mm.

    Raises
    ------
    DataError
        If the file is missing, is no such table, or its points are no curve.
    """
    rows = _rows(path)
    header = tuple(cell.lower() for cell in rows[0][1]) if rows else ()
    if header != COLUMNS:
        raise DataError(
            f"{path.name}: expected the header r,z, got {','.join(header)[:80] or 'nothing'}"
        )
    points = np.array([_point(path.name, line, cells) for line, cells in rows[1:]])
    if len(points) < 2 or not (np.diff(points, axis=0) != 0).any():
        raise DataError(
            f"{path.name}: expected at least two different points r,z along the meridian, got "
            f"{len(points)} line(s)"
        )
    return points * scale


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Line numbers and cells of all lines that count."""
    text = decode_text(read_bytes(path, what="meridian"))
    try:
        reader = csv.reader(io.StringIO(text, newline=""), skipinitialspace=True)
        table = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except csv.Error as error:
        raise DataError(f"{path.name}: expected a CSV file, got something else ({error})") from None
    return [(line, row) for line, row in table if any(row) and not row[0].startswith("#")]


def _point(name: str, line: int, cells: list[str]) -> tuple[float, float]:
    try:
        r, z = (float(cell) for cell in cells)
    except ValueError:
        r = z = math.nan
    if not (math.isfinite(r) and math.isfinite(z) and r >= 0):
        raise DataError(
            f"{name}, line {line}: expected two numbers r >= 0 and z, got {','.join(cells)[:80]!r}"
        )
    return r, z
