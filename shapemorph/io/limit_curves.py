"""Forming-limit curves as CSV files."""

import csv
import io
import math
from pathlib import Path

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.core.forming import LimitCurve
from shapemorph.io.images import read_bytes
from shapemorph.io.mtl import decode_text

COLUMNS = ("eps2", "eps1")
MEASURES = ("hencky", "engineering")


def read_limit_curve(path: Path) -> LimitCurve:
    """Read a forming-limit curve.

    Parameters
    ----------
    path : Path
        CSV with the header ``eps2,eps1``, minor before major strain. Lines ``# key: value``
        state conditions; ``# measure: engineering`` says that the numbers are changes of
        length over length and not Hencky (true) strain.

    Raises
    ------
    DataError
        If the file is missing, is no such table, or eps2 does not rise.
    """
    lines = decode_text(read_bytes(path, what="forming-limit curve")).splitlines()
    rows = [(number, line) for number, line in enumerate(lines, 1) if line.strip(" ,\t")]
    conditions = _conditions([line for _, line in rows if line.lstrip().startswith("#")])
    table = [(number, line) for number, line in rows if not line.lstrip().startswith("#")]
    header = tuple(_cells(table[0][1])) if table else ()
    if tuple(cell.lower() for cell in header) != COLUMNS:
        raise DataError(
            f"{path.name}: expected the header eps2,eps1 (minor, major Hencky strain), got "
            f"{','.join(header)[:80] or 'nothing'}"
        )
    points = np.array([_point(path.name, number, line) for number, line in table[1:]])
    points = _as_hencky(path.name, points.reshape(-1, 2), conditions)
    try:
        return LimitCurve(points[:, 0], points[:, 1], conditions)
    except DataError as error:
        raise DataError(f"{path.name}: {error}") from None


def _conditions(comments: list[str]) -> dict[str, str]:
    """Gather what lines ``# key: value`` state, by lower-case key."""
    pairs = (line.lstrip("# \t").partition(":") for line in comments)
    return {key.strip().lower(): value.strip() for key, colon, value in pairs if colon}


def _as_hencky(name: str, points: Floats, conditions: dict[str, str]) -> Floats:
    measure = conditions.get("measure", "hencky").lower()
    if measure not in MEASURES:
        raise DataError(f"{name}: expected measure hencky or engineering, got {measure[:40]!r}")
    if measure == "hencky":
        return points
    if (points <= -1).any():
        raise DataError(f"{name}: engineering strain is above -1, got {points.min():g}")
    return np.asarray(np.log1p(points), dtype=np.float64)


def _point(name: str, line: int, text: str) -> tuple[float, float]:
    try:
        minor, major = (float(cell) for cell in _cells(text))
    except ValueError:
        minor = major = math.nan
    if not (math.isfinite(minor) and math.isfinite(major)):
        raise DataError(f"{name}, line {line}: expected two numbers eps2,eps1, got {text[:80]!r}")
    return minor, major


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in next(csv.reader(io.StringIO(line)))]
