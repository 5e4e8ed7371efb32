"""batch.csv, .json and .parquet."""

import csv
import json
import sys

import pytest

from shapemorph.io.batch_tables import write_batch_tables

ROWS = [
    {
        "case": "a",
        "state": "done",
        "verdict": "WARN",
        "reason": 'few points; "half", or less',
        "seconds": 3.5,
        "report": "cases/a/report.html",
        "scorecard": {"E1 median": 0.25, "displacement max, mm": float("nan")},
    },
    {
        "case": "b",
        "state": "failed",
        "verdict": None,
        "reason": "b.obj: expected an OBJ, got\ttext",
        "seconds": None,
        "report": None,
        "scorecard": {},
    },
]


def test_the_csv_has_a_row_a_case_and_a_column_a_figure(tmp_path):
    write_batch_tables(tmp_path, ROWS)
    with (tmp_path / "batch.csv").open(newline="", encoding="utf-8") as stream:
        first, second = csv.DictReader(stream)
    assert list(first)[:6] == ["case", "state", "verdict", "reason", "seconds", "report"]
    assert first["reason"] == ROWS[0]["reason"]
    assert (first["E1 median"], first["displacement max, mm"]) == ("0.25", "nan")
    assert (second["state"], second["E1 median"], second["verdict"]) == ("failed", "", "")
    assert json.loads((tmp_path / "batch.json").read_text())["cases"][1]["case"] == "b"


def test_without_pyarrow_there_is_no_parquet_and_a_note_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    (tmp_path / "batch.parquet").write_text("of an earlier time")
    files, notes = write_batch_tables(tmp_path, ROWS)
    assert [path.name for path in files] == ["batch.csv", "batch.json"]
    assert "pip install 'shapemorph[parquet]'" in notes[0]
    assert not (tmp_path / "batch.parquet").exists()


def test_with_pyarrow_the_parquet_holds_the_same_table(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    files, notes = write_batch_tables(tmp_path, ROWS)
    assert not notes
    table = parquet.read_table(files[2]).to_pydict()
    assert table["case"] == ["a", "b"]
    assert table["E1 median"] == [0.25, None]
