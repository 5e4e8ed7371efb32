"""Tables of points in every dialect of a spreadsheet become the same cloud."""

import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.io.point_cloud import mesh_of_points, read_table

X, Y = (axis.ravel() for axis in np.meshgrid(np.arange(7.0), np.arange(5.0)))
POINTS = np.stack([X + 0.1 * Y, Y, 0.05 * X * Y], axis=1)
GREY = np.random.default_rng(1).integers(0, 256, 35)
RGB = np.random.default_rng(2).integers(0, 256, (35, 3))


def write(folder, lines, name="cloud.csv"):
    path = folder / name
    path.write_text("\n".join(lines), newline="")
    return path


def rows(separator=",", grey=GREY, decimal="."):
    return [
        separator.join(f"{value:.6g}" for value in (*point, level)).replace(".", decimal)
        for point, level in zip(POINTS, grey, strict=True)
    ]


@pytest.mark.parametrize(
    "lines",
    [
        rows(),
        rows(", "),
        rows(" "),
        rows("\t"),
        rows(";"),
        rows(";", decimal=","),
        [row + "," for row in rows()],
        ["x,y,z,grey", *rows()],
        ["X [mm],Y [mm],Z [mm],Intensity", *rows()],
        ['"x_mm","y_mm","z_mm","gray"', *rows()],
        ["# made on monday", "", "% x y z g", *rows(" "), ""],
        ["35", *rows(" ")],
        [row + "\r" for row in ["x;y;z;value", *rows(";")]],
    ],
)
def test_every_dialect_gives_the_same_points_and_grey(tmp_path, lines):
    mesh = read_table(write(tmp_path, lines))
    np.testing.assert_allclose(mesh.vertices, POINTS, rtol=1e-5)
    np.testing.assert_allclose(mesh.corner_grey, GREY[mesh.faces] / 255.0)
    assert len(mesh.faces) == 2 * 6 * 4
    assert (mesh.grey_source, mesh.notes) == ("point cloud", ())


@pytest.mark.parametrize("full", [1.0, 255.0, 65535.0])
def test_grey_is_scaled_by_the_range_that_holds_it(tmp_path, full):
    mesh = read_table(write(tmp_path, rows(grey=GREY / 255.0 * full)))
    np.testing.assert_allclose(mesh.corner_grey, GREY[mesh.faces] / 255.0, atol=1e-5)


@pytest.mark.parametrize("header", [[], ["x,y,z,r,g,b"], ["x,y,z,red,green,blue"]])
def test_colour_columns_become_luma(tmp_path, header):
    lines = [f"{x},{y},{z},{r},{g},{b}" for (x, y, z), (r, g, b) in zip(POINTS, RGB, strict=True)]
    mesh = read_table(write(tmp_path, [*header, *lines]))
    expected = RGB @ [0.2126, 0.7152, 0.0722] / 255.0
    np.testing.assert_allclose(mesh.corner_grey, expected[mesh.faces], atol=1e-9)


def test_named_columns_are_found_wherever_they_stand(tmp_path):
    lines = [
        f"{k},{g},{z},{y},{x}" for k, ((x, y, z), g) in enumerate(zip(POINTS, GREY, strict=True))
    ]
    mesh = read_table(write(tmp_path, ["id,grey,z,y,x", *lines]))
    np.testing.assert_allclose(mesh.vertices, POINTS)


def test_points_without_a_value_are_left_out_and_counted(tmp_path):
    lines = rows()
    lines[3] = "nan,1,2,3"
    lines[8] = "1,1,2,NaN"
    mesh = read_table(write(tmp_path, lines))
    assert len(mesh.vertices) == 33
    assert "2 of 35 points" in mesh.notes[0]


def test_the_same_point_twice_is_one(tmp_path):
    mesh = read_table(write(tmp_path, [*rows(), rows()[4]]))
    assert len(mesh.vertices) == 35
    assert "1 points lie on another" in mesh.notes[0]


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], "is empty"),
        (["x,y,z,grey"], "below the header, got none"),
        (["#only", "# remarks"], "expected lines X,Y,Z,grey"),
        (["1,2,3,4", "1,2,x,4"], "line 2: expected numbers, got 'x'"),
        (["1,2,3,4", "1,,3,4"], "line 2: expected numbers, got '\\(empty\\)'"),
        (["# c", "1,2,3,4", "1,2,3"], "line 3: expected 4 numbers .* got 3"),
        (["1,2,3"] * 9, "got 3 columns"),
        (["a,b,c,d,e", *["1,2,3,4,5"] * 9], r"got 5 columns \(a, b, c, d, e\)"),
        ([*rows()[:3]], "at least 4 points, got 3"),
        (rows(grey=GREY - 300), "negative"),
        (rows(grey=GREY * 1e6), "0 to 1, 255 or 65535"),
        ([f"{k},{2 * k},{3 * k},{k}" for k in range(20)], "on one line|could join"),
        (["1,2,3,4"] * 9, "all vertices at one point"),
    ],
)
def test_what_is_no_cloud_is_refused(tmp_path, lines, message):
    with pytest.raises(DataError, match=message):
        read_table(write(tmp_path, lines))


def test_binary_garbage_is_refused(tmp_path):
    path = tmp_path / "cloud.txt"
    path.write_bytes(bytes(range(256)) * 20)
    with pytest.raises(DataError, match=r"cloud\.txt"):
        read_table(path)


def test_points_that_are_not_finite_are_left_out():
    points = np.concatenate([POINTS, [[np.nan, 0, 0]]])
    mesh = mesh_of_points(points, np.append(GREY / 255.0, 0.5), name="c", file_format="PLY")
    assert len(mesh.vertices) == 35
