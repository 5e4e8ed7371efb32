import json
import math

import pytest

from shapemorph.view.tables import label_of, section_table, text_of


def _texts(table):
    return tuple((label, tuple(cell.text for cell in cells)) for label, cells in table.rows)


@pytest.mark.parametrize(
    ("key", "value", "text"),
    [
        ("ok_share", 0.98765, "98.77 %"),
        ("share of points", 1.0, "100 %"),
        ("count", 12000, "12000"),
        ("points_per_second", 123456.7, "123457"),
        ("rms_mm", 0.0061234, "0.006123"),
        ("rms_mm", math.nan, "–"),
        ("rms_mm", None, "–"),
        ("flag", True, "yes"),
        ("notes", [], "none"),
        ("sizes", [[2048, 1024], [512, 512]], "2048, 1024; 512, 512"),
        ("notes", ["a, b: c", "d"], "a, b: c; d"),
        ("names", ["lscm", "arap"], "lscm, arap"),
        ("E1", {"p1": 0.1, "median": 0.25, "p99": 0.5}, "median 0.25  (1 %: 0.1, 99 %: 0.5)"),
    ],
)
def test_values_are_written_as_people_read_them(key, value, text):
    assert text_of(key, value) == text


@pytest.mark.parametrize(
    ("key", "label"),
    [
        ("gauge_mm", "gauge, mm"),
        ("local_px_per_mm", "local, px/mm"),
        ("px_per_mm", "px/mm"),
        ("area_mm2", "area, mm²"),
        ("NOT_CONVERGED", "NOT_CONVERGED"),
        ("texels_per_px", "texels per px"),
    ],
)
def test_labels_name_their_unit(key, label):
    assert label_of(key) == label


def test_two_sides_become_two_columns_and_the_rest_follows():
    table = section_table(
        "flatten",
        "Flattening",
        {"reference": {"flips": 0, "method": "bff"}, "deformed": {"flips": 3}, "size_mm": 7.5},
    )
    assert table.columns == ("reference", "deformed")
    assert _texts(table) == (
        ("flips", ("0", "3")),
        ("method", ("bff", "")),
        ("size, mm", ("7.5", "")),
    )


def test_nested_parts_keep_their_name():
    table = section_table("points", "Points", {"statuses": {"OK": 5, "OUTLIER": 1}})
    assert _texts(table) == (("statuses: OK", ("5",)), ("statuses: OUTLIER", ("1",)))


def test_a_single_figure_is_a_table_too():
    table = section_table("peak_memory_mb", "Memory", 812.3)
    assert _texts(table) == (("peak memory, MB", ("812.3",)),)


def test_percentiles_of_one_quantity_are_one_row():
    table = section_table("displacement_mm", "Displacement", {"median": 0.5, "max": 2.0})
    assert _texts(table) == (("displacement, mm", ("median 0.5  (max: 2)",)),)


def test_long_lists_are_cut_with_their_length():
    assert "(100 in all)" in text_of("residuals_mm", [0.5] * 100)


def test_cells_keep_their_value_in_full_and_where_it_stands():
    table = section_table("strain", "Strain", {"E1": {"median": 1 / 3}, "reference": {"a": None}})
    (_, (median,)), (_, (missing,)) = table.rows
    assert (median.path, json.loads(median.exact)) == ("strain/E1", {"median": 1 / 3})
    assert (missing.path, missing.text, missing.exact) == ("strain/reference/a", "–", "null")


def test_each_section_of_a_list_has_rows_under_its_name_or_number():
    sections = [{"name": "middle", "normal": [0.0, 1.0], "length_mm": 7.5}, {"length_mm": 2.5}]
    table = section_table("forming", "Forming", {"sections": sections, "laws": []})
    assert _texts(table) == (
        ("sections: middle: name", ("middle",)),
        ("sections: middle: normal", ("0, 1",)),
        ("sections: middle: length, mm", ("7.5",)),
        ("sections: 2: length, mm", ("2.5",)),
        ("laws", ("none",)),
    )
    paths = [one.path for _, (one,) in table.rows]
    assert paths[3:] == ["forming/sections/1/length_mm", "forming/laws"]
