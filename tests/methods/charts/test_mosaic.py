import numpy as np

from shapemorph.core.image import CalibratedImage, Chart, GreyImage
from shapemorph.methods.charts.mosaic import Page, bind, page_bounds, page_of, take_page
from shapemorph.methods.parametrize.disk import Piece


def square(first_vertex, first_face, corner, size):
    plane = np.array(corner) + size * np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    piece = Piece(np.arange(first_vertex, first_vertex + 4), faces, np.array([0, 1]) + first_face)
    return Page(piece, plane, np.ones(2, dtype=bool))


def test_pages_lie_side_by_side_in_line_at_the_top():
    piece, plane, lefts = bind([square(0, 0, (5, 7), 10), square(4, 2, (-3, 0), 4)], gap=2.0)
    np.testing.assert_allclose(plane[:4].min(axis=0), [0, -10])
    np.testing.assert_allclose(plane[4:].min(axis=0), [12, -4])
    np.testing.assert_allclose(plane[4:].max(axis=0), [16, 0])
    np.testing.assert_allclose(lefts, [0, 11])
    np.testing.assert_array_equal(piece.vertex_ids, np.arange(8))
    np.testing.assert_array_equal(piece.face_ids, np.arange(4))
    np.testing.assert_array_equal(piece.faces[2:], [[4, 5, 6], [4, 6, 7]])


def test_a_page_is_a_calibrated_image_of_its_own():
    piece, plane, _ = bind([square(0, 0, (0, 0), 4), square(4, 2, (0, 0), 4)], gap=4.0)
    px = plane * [1, -1] + 1
    chart = Chart(piece.vertex_ids, piece.faces, piece.face_ids, px, 1.0, np.array([0, 7]))
    triangle = np.full((7, 15), -1, dtype=np.int32)
    triangle[1:6, 1:6], triangle[1:6, 9:14] = 1, 3
    grey = np.arange(105, dtype=np.float32).reshape(7, 15) / 105
    image = CalibratedImage(GreyImage(grey, triangle >= 0), chart, triangle, np.zeros((7, 15, 2)))
    assert page_bounds(chart, 15) == [(0, 7), (7, 15)]
    second = take_page(image, 1)
    assert second.image.shape == (7, 8)
    assert second.chart.page_count == 1
    np.testing.assert_array_equal(second.chart.vertex_ids, [4, 5, 6, 7])
    np.testing.assert_array_equal(second.chart.face_ids, [2, 3])
    assert second.triangle[3, 3] == 1
    assert second.triangle[0, 0] == -1
    np.testing.assert_allclose(second.chart.vertex_px, px[4:] - [7, 0])
    assert second.image.grey[2, 3] == image.image.grey[2, 10]


def test_points_know_their_page():
    chart = Chart(
        np.arange(3),
        np.array([[0, 1, 2]]),
        np.zeros(1, int),
        np.zeros((3, 2)),
        1.0,
        np.array([0, 10, 25]),
    )
    x = np.array([-3.0, 9.9, 10.0, 24.9, 25.1, 1e6, np.nan])
    points = np.stack([x, np.zeros(7)], axis=-1)
    assert page_of(chart, points).tolist() == [0, 0, 1, 1, 2, 2, 0]
