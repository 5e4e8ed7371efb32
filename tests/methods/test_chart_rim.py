import numpy as np

from shapemorph.core.image import Chart, SurfacePoints
from shapemorph.methods.chart_rim import extend_to


def two_triangles() -> Chart:
    """Right triangle (10 x 6 px) and its mirror; faces of the mesh are numbered 7 and 3."""
    px = np.array([[0.0, 0], [10, 0], [10, 6], [0, 6]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return Chart(np.arange(4), faces, np.array([7, 3]), px, 5.0)


def nowhere(count: int) -> SurfacePoints:
    return SurfacePoints(np.full(count, -1), np.full((count, 3), np.nan))


def test_point_just_outside_is_placed_by_linear_extension_of_its_triangle():
    chart = two_triangles()
    points = np.array([[4.0, -0.5], [-0.25, 2.0]])
    found = extend_to(chart, nowhere(2), points, reach=1.0)
    np.testing.assert_array_equal(found.face, [7, 3])
    corners = chart.vertex_px[chart.faces]
    back = np.einsum("nk,nka->na", found.barycentric, corners)
    np.testing.assert_allclose(back, points, atol=1e-12)
    np.testing.assert_allclose(found.barycentric.sum(axis=1), 1, atol=1e-12)


def test_point_beyond_reach_stays_lost_and_found_points_stay_as_they_are():
    inside = SurfacePoints(np.array([7, -1, -1]), np.full((3, 3), 1 / 3))
    points = np.array([[5.0, 1], [5, -2], [np.nan, np.nan]])
    found = extend_to(two_triangles(), inside, points, reach=1.0)
    np.testing.assert_array_equal(found.face, [7, -1, -1])
    np.testing.assert_array_equal(found.barycentric[0], inside.barycentric[0])


def test_inner_edges_are_no_rim():
    points = np.array([[5.0, 3.0]])  # on the diagonal, as if round-off had missed it
    found = extend_to(two_triangles(), nowhere(1), points, reach=1.0)
    assert found.face[0] == -1


def test_reach_of_zero_extends_nothing():
    found = extend_to(two_triangles(), nowhere(1), np.array([[5.0, -0.1]]), reach=0.0)
    assert found.face[0] == -1
