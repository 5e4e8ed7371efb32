"""Result files of a correlation between two pictures: correlation.csv and correlation.npz."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.planar import PlanarStrain
from shapemorph.io.safe_files import whole_file
from shapemorph.methods.planar_results import Table, planar_table

ROWS = 10_000  # of the table that are turned into text at once


def write_correlation(folder: Path, grid: CorrelationGrid, strain: PlanarStrain) -> list[Path]:
    """Write a grid as a table, one row for each point inside the mask.

    Parameters
    ----------
    folder : Path
    grid : CorrelationGrid
    strain : PlanarStrain
        At the points of that grid.

    Returns
    -------
    list of Path
        correlation.csv (plain header line, empty where there is no value) and
        correlation.npz (the same columns as arrays, with spacing, subset_size, strain_window
        and gauge_px); each is whole or not there.
    """
    table = planar_table(grid, strain)
    csv_path, npz_path = folder / "correlation.csv", folder / "correlation.npz"
    with whole_file(csv_path) as partial, partial.open("wb") as stream:
        stream.write(",".join(table).encode() + b"\r\n")
        stream.writelines(_rows(table))
    sizes = {
        "spacing": np.array(grid.spacing),
        "subset_size": np.array(grid.subset_size),
        "strain_window": np.array(strain.window),
        "gauge_px": np.array(strain.gauge_px),
    }
    with whole_file(npz_path) as partial, partial.open("wb") as stream:
        np.savez(stream, **table, **sizes)  # type: ignore[arg-type]
    return [csv_path, npz_path]


def _rows(table: Table) -> Iterator[bytes]:
    """Rows of the table: shortest text that reads back as the same number, or nothing."""
    from pydantic_core import to_json

    columns = list(table.values())
    for start in range(0, len(columns[0]), ROWS):
        some = [column[start : start + ROWS].tolist() for column in columns]
        text = to_json(list(zip(*some, strict=True)), inf_nan_mode="null")[2:-2]
        yield text.replace(b"],[", b"\r\n").replace(b"null", b"") + b"\r\n"
