"""Meridians: points in order, in mm, or a message that names the line."""

import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.io.meridian_files import read_meridian


def test_points_come_out_in_mm_and_in_order(tmp_path):
    path = tmp_path / "fe.csv"
    path.write_text("# 0.4 MPa\nR, Z\n0, 2.5\n\n1.5,2.25\n1.5 , -1\n")
    points = read_meridian(path, scale=10.0)
    np.testing.assert_allclose(points, [[0, 25], [15, 22.5], [15, -10]])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("x,y\n0,1\n", "expected the header r,z, got x,y"),
        ("r,z\n0,1\n-1,2\n", r"line 3: expected two numbers r >= 0 and z, got '-1,2'"),
        ("r,z\n0,1\n1,two\n", "line 3"),
        ("r,z\n0,1\n1,2,3\n", "line 3"),
        ("r,z\n0,1\n1,nan\n", "line 3"),
        ("r,z\n0,1\n0,1\n", "at least two different points"),
        ("r,z\n", "at least two different points"),
        ("# nothing\n", "got nothing"),
    ],
)
def test_what_is_no_meridian_is_refused(tmp_path, text, says):
    path = tmp_path / "m.csv"
    path.write_text(text)
    with pytest.raises(DataError, match=says):
        read_meridian(path, scale=1.0)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(DataError, match=r"absent\.csv does not exist"):
        read_meridian(tmp_path / "absent.csv", scale=1.0)
