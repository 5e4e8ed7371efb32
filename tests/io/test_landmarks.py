"""Landmarks are read as contracted, and every mistake is named by line and column."""

import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.io.landmarks import read_landmarks

HEADER = "name,ref_x,ref_y,ref_z,def_x,def_y,def_z"


def read(folder, *lines, **scales):
    path = folder / "landmarks.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    return read_landmarks(path, **({"reference_scale": 1.0, "deformed_scale": 1.0} | scales))


def test_positions_are_scaled_each_by_the_unit_of_its_file(tmp_path):
    points = read(
        tmp_path,
        "\ufeff" + HEADER,
        "# first the nose",
        "tip of the nose, 1, 2, 3, 4e0, -5, .5",
        "",
        '"left, upper", 0, 0, 0, 1, 1, 1',
        reference_scale=10.0,
        deformed_scale=1000.0,
    )
    assert points.names == ("tip of the nose", "left, upper")
    np.testing.assert_allclose(points.reference, [[10, 20, 30], [0, 0, 0]])
    np.testing.assert_allclose(points.deformed, [[4000, -5000, 500], [1000, 1000, 1000]])


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ((HEADER,), "expected landmarks below the header"),
        (("",), "is empty"),
        (("\n\n",), "line 1: expected the header .* got nothing"),
        (("a,1,2,3,4,5,6",), "line 1: expected the header name,ref_x"),
        ((HEADER, "a,1,2,3,4,5,6", "b,1,2,x,4,5,6"), "line 3, column ref_z: .* got 'x'"),
        ((HEADER, "a,1,2,3,4,,6"), "line 2, column def_y: .* got ''"),
        ((HEADER, "a,1,2,3,4,5,inf"), "line 2, column def_z: .* got 'inf'"),
        ((HEADER, "a,1,2,3,4,5"), "line 2: expected 7 columns .* got 6"),
        ((HEADER, "a,1,2,3,4,5,6", "", "a,1,2,3,4,5,7"), "line 4, column name: 'a' is there twice"),
    ],
)
def test_mistakes_are_named_by_line_and_column(tmp_path, lines, message):
    with pytest.raises(DataError, match=message):
        read(tmp_path, *lines)


def test_a_missing_file_is_a_clear_error(tmp_path):
    with pytest.raises(DataError, match=r"landmarks file .* does not exist"):
        read_landmarks(tmp_path / "none.csv", reference_scale=1.0, deformed_scale=1.0)
