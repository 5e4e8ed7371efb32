"""correlation.csv and correlation.npz hold the same table."""

import csv

import numpy as np
from numpy.testing import assert_array_equal

from shapemorph.core.grid import CorrelationGrid
from shapemorph.io.correlation_files import write_correlation
from shapemorph.methods.planar_results import planar_table
from shapemorph.methods.planar_strain import planar_strain


def _grid():
    reference = np.stack(np.meshgrid([4.0, 8.0, 12.0], [4.0, 8.0]), axis=-1)
    status = np.array([[0, 0, 1], [5, 0, 0]], dtype=np.uint8)
    lost = (status != 0)[..., None]
    deformed = np.where(lost, np.nan, reference * 1.01 + 1 / 3)
    gradient = np.where(lost[..., None], np.nan, 1.01 * np.eye(2))
    zncc = np.array([[0.99, 0.98, np.nan], [0.2, 0.97, 1.0]])
    return CorrelationGrid(
        reference, deformed, gradient, zncc, np.full((2, 3), 3), 0.01 * deformed, status,
        spacing=4, subset_size=15, kernel_seconds=0.1,
    )  # fmt: skip


def _field():
    return _grid(), planar_strain(_grid(), window=3)


def test_the_csv_reads_back_to_the_last_bit(tmp_path):
    paths = write_correlation(tmp_path / "new", *_field())
    assert [path.name for path in paths] == ["correlation.csv", "correlation.npz"]
    with paths[0].open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    table = planar_table(*_field())
    assert list(rows[0]) == list(table)
    for name, column in table.items():
        read = [float(row[name]) if row[name] else np.nan for row in rows]
        assert_array_equal(read, column)


def test_a_missing_value_is_an_empty_field(tmp_path):
    lines = write_correlation(tmp_path, *_field())[0].read_text(encoding="utf-8").splitlines()
    lost = next(line for line in lines if line.startswith("4,8,"))
    assert lost == "4,8,,,,,,,0.2,3,5" + 14 * ","


def test_the_npz_has_the_same_columns_and_needs_no_pickle(tmp_path):
    with np.load(write_correlation(tmp_path, *_field())[1], allow_pickle=False) as arrays:
        for name, column in planar_table(*_field()).items():
            assert_array_equal(arrays[name], column)
        assert (arrays["spacing"], arrays["subset_size"]) == (4, 15)
        assert (arrays["strain_window"], arrays["gauge_px"]) == (3, 2 * 4 + 15)


def test_no_partial_files_are_left(tmp_path):
    write_correlation(tmp_path, *_field())
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "correlation.csv",
        "correlation.npz",
    ]
