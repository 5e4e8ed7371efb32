"""Result files of a measurement: measurement.vtp, .csv and .glb, facets.vtp."""

import csv
from pathlib import Path
from typing import Any

import numpy as np

import shapemorph
from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.core.measurement import Facets, Measurement
from shapemorph.io.coloured_glb import write_coloured_glb
from shapemorph.io.quantities import INTEGER_COLUMNS, QUANTITIES, REFERENCE, Quantity
from shapemorph.io.safe_files import whole_file
from shapemorph.io.vtk_files import write_surface

_MILLIMETRES_PER_METRE = 1000.0
_UNITS = "mm"
FACETS = "facets.vtp"


def write_measurement(folder: Path, measurement: Measurement, config: str) -> list[Path]:
    """Write measurement.vtp, .csv and .glb, and facets.vtp, into a folder.

    Parameters
    ----------
    folder : Path
    measurement : Measurement
    config : str
        Configuration of the run as JSON; it becomes field data beside units and version.

    Returns
    -------
    list of Path
        What was written; each file is whole or not there. Scattered points without a
        single cell have no surface: then there is no measurement.glb and no facets.vtp.
    """
    paths = [folder / f"measurement.{suffix}" for suffix in ("vtp", "csv", "glb")]
    fields = {"config": config, "units": _UNITS, "version": shapemorph.__version__}
    write_vtp(paths[0], measurement, fields)
    write_csv(paths[1], measurement)
    if len(measurement.cells) == 0:
        return paths[:2]
    write_glb(paths[2], measurement)
    if measurement.facets is not None:
        paths.append(folder / FACETS)
        write_facets(paths[3], measurement, measurement.facets, fields)
    return paths


def write_vtp(path: Path, measurement: Measurement, fields: dict[str, str]) -> None:
    """Write points, quads, point arrays and field data for ParaView and scripts."""
    write_surface(path, measurement.reference, measurement.cells, measurement.arrays, fields)


def read_vtp(path: Path) -> tuple[Measurement, dict[str, str]]:
    """Read a measurement and its field data back.

    Raises
    ------
    DataError
        If the file is missing or is not a measurement.
    """
    import pyvista

    if not path.is_file():
        raise DataError(f"{path} does not exist: expected a measurement.vtp")
    surface = pyvista.read(path)
    if not isinstance(surface, pyvista.PolyData) or "deformed_position" not in surface.point_data:
        raise DataError(f"{path} holds no measurement: expected PolyData with deformed_position")
    arrays = {name: np.asarray(surface.point_data[name]) for name in surface.point_data}
    fields = {name: str(surface.field_data[name][0]) for name in surface.field_data}
    cells = surface.regular_faces.reshape(-1, 4)
    points = np.asarray(surface.points, dtype=np.float64)
    return Measurement(points, np.asarray(cells, dtype=np.int64), arrays), fields


def write_facets(
    path: Path, measurement: Measurement, facets: Facets, fields: dict[str, str]
) -> None:
    """Write the facets on the reference shape, with an array a measure."""
    write_surface(path, measurement.reference, facets.corners, facets.arrays, fields, of_cells=True)


def read_facets(path: Path) -> Facets:
    """Read facets back.

    Raises
    ------
    DataError
        If the file holds none.
    """
    import pyvista

    surface = pyvista.read(path)
    if not isinstance(surface, pyvista.PolyData) or "E1" not in surface.cell_data:
        raise DataError(f"{path} holds no facets: expected PolyData with E1 for each cell")
    corners = np.asarray(surface.regular_faces, dtype=np.int64).reshape(-1, 3)
    return Facets(corners, {k: np.asarray(surface.cell_data[k]) for k in surface.cell_data})


def table_columns(measurement: Measurement) -> dict[str, Floats]:
    """Columns of measurement.csv, in order, with the unit in every name that has one."""
    columns = _columns(REFERENCE, measurement.reference)
    for quantity in QUANTITIES:
        if not quantity.only_with or quantity.name in measurement.arrays:
            columns |= _columns(quantity, measurement.arrays[quantity.name])
    return columns


def write_csv(path: Path, measurement: Measurement) -> None:
    """Write one row a point; missing values are `nan`, numbers hold 10 significant digits."""
    write_table(path, table_columns(measurement))


def write_table(path: Path, columns: dict[str, Floats]) -> None:
    """Write columns (N,) under their names, likewise; the folder is made where missing."""
    formats = ["%d" if name in INTEGER_COLUMNS else "%.10g" for name in columns]
    table = np.stack(
        [np.nan_to_num(v) if n in INTEGER_COLUMNS else v for n, v in columns.items()], axis=1
    )
    with whole_file(path) as partial:
        np.savetxt(
            partial, table, formats, ",", header=",".join(columns), comments="", encoding="utf-8"
        )


def read_csv(path: Path) -> dict[str, Floats]:
    """Read the columns of a measurement.csv.

    Raises
    ------
    DataError
        If the file is missing or is no table of numbers.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file)
        table = np.array(rows, dtype=np.float64).reshape(len(rows), len(header))
    except (OSError, ValueError) as error:
        raise DataError(f"{path}: expected a measurement.csv, got {error}") from error
    return dict(zip(header, table.T, strict=True))


def write_glb(path: Path, measurement: Measurement) -> None:
    """Write the deformed shape in metres, coloured by E1, for any viewer.

    Raises
    ------
    DataError
        If no cell has a value.
    """
    if len(measurement.cells) == 0:
        raise DataError(
            f"{path.name}: expected at least one cell of four OK neighbours, got none: lower "
            "correlate.spacing"
        )
    used, cells = np.unique(measurement.cells, return_inverse=True)
    corners = cells.reshape(-1, 4)
    e1 = measurement.arrays["E1"][used]
    extras: dict[str, Any] = {
        "length_unit": "m",
        "scalar": "_E1",
        "quantity": "Green-Lagrange strain E1, major principal value",
        "unit": "1",
        "range": [float(e1.min()), float(e1.max())],
    }
    with whole_file(path) as partial:
        write_coloured_glb(
            partial,
            measurement.arrays["deformed_position"][used] / _MILLIMETRES_PER_METRE,
            np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]]),
            ("_E1", e1),
            extras,
        )


def _columns(quantity: Quantity, values: Floats) -> dict[str, Floats]:
    """Columns of one array by their names in the table."""
    components = values.reshape(len(values), -1).T
    return dict(zip(quantity.columns, components, strict=False))
