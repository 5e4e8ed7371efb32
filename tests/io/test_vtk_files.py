"""VTK files, read back by pyvista."""

import numpy as np
import pyvista

from shapemorph.io.vtk_files import write_image_data, write_surface

POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5], [2, 0, 0]])


def test_a_picture_keeps_its_first_row_at_the_bottom(tmp_path):
    values = np.arange(6.0, dtype=np.float32).reshape(2, 3)
    path = tmp_path / "a.vti"
    write_image_data(path, (2, 3), 0.5, {"v": values}, {"scale": 2.0, "unit": "mm"})
    image = pyvista.read(path)
    assert image.dimensions == (3, 2, 1)
    assert image.find_closest_point((0.5, 0, 0)) == 1
    assert image.point_data["v"].tolist() == [0, 1, 2, 3, 4, 5]
    assert image.point_data["v"].dtype == np.float32
    assert image.field_data["scale"][0] == 2.0
    assert str(image.field_data["unit"][0]) == "mm"


def test_a_surface_comes_back_with_its_quads_and_vectors(tmp_path):
    path = tmp_path / "a.vtp"
    status = np.arange(5, dtype=np.uint8)
    arrays = {"status": status, "d": np.full((5, 3), np.nan)}
    write_surface(path, POINTS, np.array([[0, 1, 2, 3]]), arrays, {"note": "a < b & c"})
    surface = pyvista.read(path)
    assert surface.regular_faces.tolist() == [[0, 1, 2, 3]]
    assert np.array_equal(surface.points, POINTS)
    assert surface.point_data["status"].dtype == np.uint8
    assert np.isnan(surface.point_data["d"]).all()
    assert str(surface.field_data["note"][0]) == "a < b & c"


def test_points_without_quads_can_be_seen(tmp_path):
    write_surface(tmp_path / "a.vtp", POINTS, np.zeros((0, 4), np.int64), {}, {})
    assert pyvista.read(tmp_path / "a.vtp").n_cells == 5


def test_a_folder_that_is_not_there_is_made(tmp_path):
    write_surface(tmp_path / "new" / "a.vtp", POINTS, np.zeros((0, 4), np.int64), {}, {})
    assert (tmp_path / "new" / "a.vtp").is_file()
