"""frames.csv: one row for each picture of a sequence."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from shapemorph.io.safe_files import whole_file


def write_frame_table(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows that have one set of keys; NaN becomes empty, truth 1 or 0."""
    with whole_file(path) as partial, partial.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(rows[0])
        writer.writerows([_text(value) for value in row.values()] for row in rows)


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float):
        return "" if value != value else repr(value)  # noqa: PLR0124 - only NaN differs from itself
    return str(value)
