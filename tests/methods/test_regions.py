import numpy as np
import pytest

from shapemorph.core.errors import ConfigError
from shapemorph.core.image import Chart
from shapemorph.core.mesh import coloured_mesh
from shapemorph.core.region import Region
from shapemorph.methods.calibrating import calibrate
from shapemorph.methods.regions import fill_polygon, region_mask


@pytest.fixture(scope="module")
def plate():
    vertices = np.array([[0.0, 0, 5], [20, 0, 5], [20, 12, 5], [0, 12, 5]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    mesh = coloured_mesh(vertices, faces, np.full((2, 3), 0.5), name="plate.ply")
    px = vertices[:, :2] * [5, -5] + [4, 64]
    return mesh, calibrate(mesh, Chart(np.arange(4), faces, np.arange(2), px, 5.0))[0]


def test_no_region_is_the_whole_surface(plate):
    mesh, image = plate
    np.testing.assert_array_equal(region_mask(None, mesh, image), image.image.mask)
    np.testing.assert_array_equal(region_mask(Region(), mesh, image), image.image.mask)


def test_a_ball_is_measured_in_space(plate):
    mesh, image = plate
    region = Region(centre=np.array([8.0, 7.0, 8.0]), radius=5.0)
    rows, cols = np.nonzero(region_mask(region, mesh, image))
    x, y = (cols - 4) / 5, (64 - rows) / 5
    assert np.hypot(x - 8, y - 7).max() == pytest.approx(4.0, abs=0.2)  # 3 mm above the plate
    assert len(rows) / 25 == pytest.approx(np.pi * 16, rel=0.03)


def test_every_given_limit_applies(plate):
    mesh, image = plate
    half = np.zeros(image.image.shape, dtype=bool)
    half[:, :50] = True
    polygon = np.array([[20.0, 10], [90, 10], [90, 40], [20, 40]])
    found = region_mask(Region(polygons=(polygon,), mask=half), mesh, image)
    expected = np.zeros_like(half)
    expected[10:40, 20:50] = True
    np.testing.assert_array_equal(found, expected & image.image.mask)


def test_a_region_may_have_several_parts_and_holes(plate):
    mesh, image = plate
    left = np.array([[20.0, 10], [40, 10], [40, 40], [20, 40]])
    right = left + np.array([20, 0])
    hole = np.array([[30.0, 20], [50, 20], [50, 30], [30, 30]])
    found = region_mask(Region(polygons=(left, right), holes=(hole,)), mesh, image)
    expected = np.zeros(image.image.shape, dtype=bool)
    expected[10:40, 20:60] = True
    expected[20:30, 30:50] = False
    np.testing.assert_array_equal(found, expected)


def test_a_mask_of_another_size_is_refused_with_both_sizes(plate):
    mesh, image = plate
    height, width = image.image.shape
    with pytest.raises(ConfigError, match=f"{width} x {height} px.*got 50 x 40"):
        region_mask(Region(mask=np.ones((40, 50), dtype=bool)), mesh, image)


def test_a_region_without_surface_is_refused(plate):
    mesh, image = plate
    with pytest.raises(ConfigError, match=r"no pixel of plate\.ply"):
        region_mask(Region(centre=np.array([500.0, 0, 0]), radius=2.0), mesh, image)


def test_a_polygon_may_be_concave_and_leave_the_picture():
    corners = np.array([[-10.0, 5.5], [30.2, 5.5], [30.2, 20.5], [12.4, 9.5], [-10, 20.5]])
    inside = fill_polygon(corners, (24, 40))
    rows, cols = np.mgrid[0:24, 0:40]
    expected = (rows > 5) & (cols < 30.2) & (rows < 20.5)
    right = rows < 9.5 + (cols - 12.4) / (30.2 - 12.4) * 11
    left = rows < 9.5 + (12.4 - cols) / 22.4 * 11
    np.testing.assert_array_equal(inside, expected & np.where(cols > 12.4, right, left))


def test_two_polygons_side_by_side_share_no_pixel():
    one = np.array([[2.0, 2], [10, 2], [14, 12], [2, 12]])
    other = np.array([[10.0, 2], [20, 2], [20, 12], [14, 12]])
    both = fill_polygon(one, (16, 24)).astype(int) + fill_polygon(other, (16, 24))
    assert both.max() == 1
    assert both.sum() == 18 * 10
