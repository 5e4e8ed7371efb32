import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.view.camera import fit_frame, outer_view, second_view


def _sheet(turn):
    x, y = np.meshgrid(np.linspace(0, 3, 7), np.linspace(0, 2, 5))
    points = np.stack([x, y, 0.1 * x * y], axis=-1).reshape(-1, 3) @ turn.T
    ids = np.arange(35).reshape(5, 7)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], -1).reshape(-1, 4)
    return points, quads


def test_camera_stands_on_the_side_from_which_cells_run_counter_clockwise():
    points, quads = _sheet(np.eye(3))
    assert outer_view(points, quads).toward[2] > 0.9
    assert outer_view(points, quads[:, ::-1]).toward[2] < -0.9
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    assert_allclose(
        outer_view(points, triangles).toward, outer_view(points, quads).toward, atol=1e-3
    )


def test_axes_of_the_picture_are_right_handed_and_y_is_up():
    view = outer_view(*_sheet(np.eye(3)))
    assert_allclose(np.cross(view.right, view.up), view.toward, atol=1e-12)
    assert view.up[1] > 0.9
    assert view.right[0] > 0.9


def test_a_surface_that_faces_along_y_has_z_up():
    swap = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
    assert outer_view(*_sheet(swap)).up[2] > 0.9


def test_a_tube_is_seen_from_its_side():
    angle, height = np.meshgrid(np.linspace(0, 2 * np.pi, 41), np.linspace(0, 9, 10))
    points = np.stack([np.cos(angle), 1.3 * np.sin(angle), height], -1).reshape(-1, 3)
    ids = np.arange(410).reshape(10, 41)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], -1).reshape(-1, 4)
    assert abs(outer_view(points, quads).toward[2]) < 1e-6


def test_a_wide_shape_is_seen_from_below_and_a_tall_one_from_the_right():
    points, quads = _sheet(np.eye(3))
    view = outer_view(points, quads)
    low = second_view(view, points, 0.6)
    assert view.toward @ low.up == pytest.approx(np.sin(0.6))
    assert low.toward @ low.up == pytest.approx(0, abs=1e-12)
    side = second_view(view, points * [1, 3, 1], 0.6)
    assert_allclose(side.up, view.up)
    assert side.toward @ view.right == pytest.approx(np.sin(0.6))


def test_shape_fills_its_frame():
    points, quads = _sheet(np.eye(3))
    view = outer_view(points, quads)
    frame = fit_frame(points, view, width=600, height=500)
    flat = (view.project(points) - view.project(frame.centre[None])) / frame.mm_per_px
    assert np.abs(flat[:, 0]).max() * 2 == pytest.approx(frame.width / 1.06, abs=2)
    assert np.abs(flat[:, 1]).max() * 2 == pytest.approx(frame.height / 1.06, abs=2)
    assert frame.width == 600
    assert frame.height < 450
