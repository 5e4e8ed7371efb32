"""The table of a batch: batch.csv, batch.json and, where pyarrow is there, batch.parquet."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from shapemorph.io.safe_files import whole_file, write_json

_ORDER = ("case", "state", "verdict", "reason", "seconds", "report")
_NO_PARQUET = "batch.parquet was left out: pip install 'shapemorph[parquet]'"

Rows = Sequence[Mapping[str, Any]]


def write_batch_tables(folder: Path, rows: Rows) -> tuple[list[Path], list[str]]:
    """Write one row a case, each file whole or not there.

    Parameters
    ----------
    folder : Path
    rows : sequence of mapping
        ``case``, ``state``, ``verdict``, ``reason``, ``seconds``, ``report`` and the figures
        of the ``scorecard``, which become columns.

    Returns
    -------
    files : list of Path
    notes : list of str
        What was left out.
    """
    table = batch_table(rows)
    files = [folder / "batch.csv", folder / "batch.json"]
    with whole_file(files[0]) as partial:
        _write_csv(partial, table)
    write_json(files[1], {"cases": list(rows)})
    parquet = folder / "batch.parquet"
    if _write_parquet(parquet, table):
        return [*files, parquet], []
    parquet.unlink(missing_ok=True)
    return files, [_NO_PARQUET]


def batch_table(rows: Rows) -> dict[str, list[Any]]:
    """Columns of the table; None where a case has no value."""
    figures = list(dict.fromkeys(key for row in rows for key in row["scorecard"]))
    flat = [{**row, **row["scorecard"]} for row in rows]
    return {name: [row.get(name) for row in flat] for name in (*_ORDER, *figures)}


def _write_csv(path: Path, table: Mapping[str, Sequence[Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(table)
        for cells in zip(*table.values(), strict=True):
            writer.writerow("" if cell is None else cell for cell in cells)


def _write_parquet(path: Path, table: Mapping[str, Sequence[Any]]) -> bool:
    """Write the table if pyarrow is installed, and say whether."""
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        return False
    with whole_file(path) as partial:
        parquet.write_table(pa.table(dict(table)), partial)
    return True
