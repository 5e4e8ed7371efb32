import numpy as np
import pytest

from shapemorph.core.image import Chart
from shapemorph.core.mesh import coloured_mesh
from shapemorph.io.calibrated_files import write_calibrated
from shapemorph.io.images import read_grey_image
from shapemorph.methods.calibrating import calibrate


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    vertices = np.array([[0.0, 0, 5], [9, 0, 6], [9, 6, 7], [0, 6, 5.5]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    grey = np.array([[0.1, 0.5, 0.9], [0.1, 0.9, 0.4]])
    mesh = coloured_mesh(vertices, faces, grey, name="plate")
    px = vertices[:, :2] * [8, -8] + [4, 52]
    chart = Chart(np.arange(4), faces, np.array([0, 1]), px, 8.0)
    image, _ = calibrate(mesh, chart)
    folder = tmp_path_factory.mktemp("flatten")
    write_calibrated(folder / "reference.v2", mesh, image)
    return image, folder


def test_the_vti_has_its_first_row_at_the_bottom_and_spacing_in_mm(written):
    import pyvista

    image, folder = written
    grid = pyvista.read(folder / "reference.v2.vti")
    height, width = image.image.shape
    assert grid.dimensions == (width, height, 1)
    assert grid.spacing[:2] == (0.125, 0.125)
    arrays = {name: np.reshape(grid.point_data[name], (height, width))[::-1] for name in "XYZ"}
    rows, cols = np.nonzero(image.image.mask)
    np.testing.assert_allclose(arrays["X"][rows, cols], (cols - 4) / 8, atol=1e-12)
    np.testing.assert_allclose(arrays["Y"][rows, cols], (52 - rows) / 8, atol=1e-12)
    assert np.isnan(arrays["Z"][~image.image.mask]).all()


def test_the_vti_holds_grey_and_the_face_of_the_mesh(written):
    import pyvista

    image, folder = written
    grid = pyvista.read(folder / "reference.v2.vti")
    shape = image.image.shape
    face = np.reshape(grid.point_data["face"], shape)[::-1]
    np.testing.assert_array_equal(face, image.triangle)
    gray = np.reshape(grid.point_data["gray"], shape)[::-1]
    mask = image.image.mask
    np.testing.assert_array_equal(gray[mask], image.image.grey[mask])
    assert np.isnan(gray[~mask]).all()


def test_the_picture_shows_grey_and_mask(written):
    image, folder = written
    picture = read_grey_image(folder / "reference.v2.png")
    np.testing.assert_array_equal(picture.mask, image.image.mask)
    mask = picture.mask
    np.testing.assert_allclose(picture.grey[mask], image.image.grey[mask], atol=0.5 / 255 + 1e-6)


def test_nothing_else_is_left_behind(written):
    _, folder = written
    assert sorted(path.name for path in folder.iterdir()) == [
        "reference.v2.png",
        "reference.v2.vti",
    ]
