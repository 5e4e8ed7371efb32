"""Result files of a correlation between two pictures: correlation.csv and correlation.npz."""

import csv
from pathlib import Path

import numpy as np

from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.planar import PlanarStrain
from shapemorph.io.safe_files import whole_file
from shapemorph.methods.planar_results import planar_table


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
    with whole_file(csv_path) as partial, partial.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(table)
        columns = [_as_text(column) for column in table.values()]
        writer.writerows(zip(*columns, strict=True))
    sizes = {
        "spacing": np.array(grid.spacing),
        "subset_size": np.array(grid.subset_size),
        "strain_window": np.array(strain.window),
        "gauge_px": np.array(strain.gauge_px),
    }
    with whole_file(npz_path) as partial, partial.open("wb") as stream:
        np.savez(stream, **table, **sizes)  # type: ignore[arg-type]
    return [csv_path, npz_path]


def _as_text(column: np.ndarray[tuple[int, ...], np.dtype[np.generic]]) -> list[str]:
    """Shortest text that reads back as the same number; nothing for a missing one."""
    if column.dtype.kind != "f":
        return [str(value) for value in column.tolist()]
    return ["" if value != value else repr(value) for value in column.tolist()]  # noqa: PLR0124
