import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.io.target_files import read_target, write_target


def cylinder(radius=40.0):
    rows, columns = np.mgrid[:6, :8]
    angle = 0.25 * columns.ravel()
    normals = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    points = radius * normals + np.outer(rows.ravel() * 9.0, [0, 0, 1])
    return rows.ravel(), columns.ravel(), points, normals


def test_normals_of_a_cylinder_point_outward(tmp_path):
    rows, columns, points, normals = cylinder()
    lines = ["row,column,x_mm,y_mm,z_mm"]
    lines += [f"{r},{c},{x},{y},{z}" for r, c, (x, y, z) in zip(rows, columns, points, strict=True)]
    path = tmp_path / "target.csv"
    path.write_text("\n".join(lines))
    target = read_target(path)
    angle = np.degrees(np.arccos((target.normals * normals).sum(axis=1).clip(-1, 1)))
    assert angle.max() < 2.0
    write_target(tmp_path / "again.csv", target)
    np.testing.assert_allclose(read_target(tmp_path / "again.csv").points, points, atol=1e-6)


def test_a_flat_target_has_no_normals(tmp_path):
    lines = ["row,column,x_mm,y_mm,z_mm", "0,0,0,0,0", "0,1,5,0,0", "1,0,0,5,0", "1,1,5,5,0"]
    (tmp_path / "flat.csv").write_text("\n".join(lines))
    assert read_target(tmp_path / "flat.csv").normals is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2\n", "row is missing"),
        ("row,column,x_mm,y_mm,z_mm\n1,1,0,0,five\n", "line 2"),
        ("row,column,x_mm,y_mm,z_mm\n1,1,0,0\n", "expected finite"),
        ("row,column,x_mm,y_mm,z_mm\n" + "1,1,0,0,0\n" * 2, "stands there twice"),
        ("row,column,x_mm,y_mm,z_mm\n1,1,0,0,0\n", "at least 4 points"),
    ],
)
def test_says_what_is_wrong(tmp_path, text, message):
    (tmp_path / "target.csv").write_text(text)
    with pytest.raises(DataError, match=message):
        read_target(tmp_path / "target.csv")
