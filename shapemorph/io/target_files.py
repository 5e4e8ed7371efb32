"""Targets in space: dots of known coordinates, from a CSV file."""

import csv
from pathlib import Path

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.calibration import Target
from shapemorph.core.errors import DataError
from shapemorph.methods.cameras.surface_normals import outward_normals

COLUMNS = ("row", "column", "x_mm", "y_mm", "z_mm")
NORMALS = ("nx", "ny", "nz")


def read_target(path: Path) -> Target:
    """Read the dots of a target.

    Parameters
    ----------
    path : Path
        CSV with a header: row, column, x_mm, y_mm, z_mm, one line a dot; nx, ny, nz if the
        surface does not bulge outward everywhere.

    Raises
    ------
    DataError
        If the file is missing or not of that form.
    """
    rows = _rows(path)
    table = np.array([[row[name] for name in COLUMNS] for row in rows])
    lattice = np.rint(table[:, :2]).astype(np.int64)
    if len(np.unique(lattice, axis=0)) < len(lattice):
        raise DataError(f"{path.name}: a row and column stands there twice")
    points = table[:, 2:]
    if not points[:, 2].any():
        normals = None
    elif all(name in rows[0] for name in NORMALS):
        normals = np.array([[row[name] for name in NORMALS] for row in rows])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    else:
        normals = outward_normals(points, lattice)
    return Target(path.stem, points, normals=normals, lattice=lattice)


def _rows(path: Path) -> list[dict[str, float]]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = list(csv.DictReader(file, skipinitialspace=True))
    except FileNotFoundError:
        raise DataError(f"target file {path} does not exist: check the path") from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataError(f"target file {path} cannot be read ({error})") from None
    missing = [name for name in COLUMNS if not lines or name not in lines[0]]
    if missing:
        raise DataError(
            f"{path.name}: expected a header {','.join(COLUMNS)} and a line for each dot, "
            f"{missing[0]} is missing"
        )
    return [_numbers(line, number + 2, path) for number, line in enumerate(lines)]


def _numbers(line: dict[str, str], number: int, path: Path) -> dict[str, float]:
    try:
        values = {
            name: float(line[name])
            for name in (*COLUMNS, *NORMALS)
            if line.get(name) not in (None, "")
        }
    except ValueError as error:
        raise DataError(f"{path.name} line {number}: {error}") from None
    if not all(name in values for name in COLUMNS) or not all(np.isfinite(list(values.values()))):
        raise DataError(f"{path.name} line {number}: expected finite {', '.join(COLUMNS)}")
    return values


def write_target(path: Path, target: Target) -> None:
    """Write a target as :func:`read_target` reads it."""
    if target.lattice is None:
        raise DataError("a target without rows and columns has no file")
    table: Floats = np.column_stack([target.lattice, target.points])
    lines = [f"{int(r)},{int(c)},{x:.6f},{y:.6f},{z:.6f}" for r, c, x, y, z in table.tolist()]
    path.write_text("\n".join([",".join(COLUMNS), *lines]) + "\n", encoding="utf-8")
