"""The table of quantities, the page that is made from it, and the files."""

from pathlib import Path

import numpy as np

from shapemorph.core.grid import CorrelationGrid
from shapemorph.io.outputs_page import outputs_page
from shapemorph.io.quantities import PLANAR, QUANTITIES, REFERENCE
from shapemorph.methods.planar_results import planar_table
from shapemorph.methods.planar_strain import planar_strain

DOCS = Path(__file__).parents[2] / "docs"


def test_the_page_is_the_one_that_the_table_makes():
    page = (DOCS / "outputs.md").read_text(encoding="utf-8")
    assert page == outputs_page(), "run tools/outputs_page.py"


def test_every_column_with_a_unit_names_it():
    for quantity in (REFERENCE, *QUANTITIES):
        for column in quantity.columns:
            named = column.endswith(("_mm", "_px", "_rad"))
            unit = column.rpartition("_")[2] if named else "1"
            assert unit == quantity.unit, column


def test_no_name_stands_twice():
    names = [quantity.name for quantity in QUANTITIES]
    columns = [column for quantity in (REFERENCE, *QUANTITIES) for column in quantity.columns]
    assert len(set(names)) == len(names)
    assert len(set(columns)) == len(columns)


def test_the_table_of_two_pictures_is_listed_whole_and_in_order():
    points = np.zeros((2, 3, 2))
    status = np.zeros((2, 3), dtype=np.uint8)
    gradient = np.zeros((2, 3, 2, 2))
    grid = CorrelationGrid(
        points, points, gradient, status + 1.0, status + 3, points, status,
        spacing=4, subset_size=15, kernel_seconds=0.1,
    )  # fmt: skip
    assert [name for name, *_ in PLANAR] == list(planar_table(grid, planar_strain(grid, window=3)))
