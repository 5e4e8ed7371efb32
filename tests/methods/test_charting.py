import numpy as np
import pytest

from shapemorph.core.errors import StageError
from shapemorph.methods.charting import (
    chart_at_scale,
    picture_shape,
    to_principal_axes,
    to_unit_scale,
)
from shapemorph.methods.parametrize.disk import Piece


def _sheet():
    number = np.arange(7 * 12).reshape(7, 12)
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, 1:].ravel(), number[1:, :-1].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    y, x = np.divmod(np.arange(84), 12)
    vertices = np.stack([x, y, 0 * x], axis=1).astype(np.float64)
    return vertices, Piece(np.arange(84), faces, np.arange(len(faces)))


def test_half_of_the_area_is_magnified_and_half_reduced():
    vertices, piece = _sheet()
    plane = to_unit_scale(vertices, piece, 7.5 * vertices[:, :2])
    np.testing.assert_allclose(plane, vertices[:, :2], atol=1e-12)


def test_a_sheet_upside_down_is_refused():
    vertices, piece = _sheet()
    with pytest.raises(StageError, match="no face lies the right way up"):
        to_unit_scale(vertices, piece, vertices[:, :2] * [1, -1])


@pytest.mark.parametrize("angle", [0.0, 0.5, 1.7, 3.0, -2.0])
def test_however_it_came_the_sheet_lies_along_x_with_y_up(angle):
    vertices, piece = _sheet()
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    placed = to_principal_axes(vertices, piece, vertices[:, :2] @ turn.T + [100, -30])
    np.testing.assert_allclose(placed, vertices[:, :2] - [5.5, 3.0], atol=1e-9)


def test_a_chart_keeps_a_margin_and_runs_against_the_screen():
    vertices, piece = _sheet()
    chart = chart_at_scale(piece, vertices[:, :2], px_per_mm=10.0)
    np.testing.assert_allclose(chart.vertex_px.min(axis=0), [4, 4])
    assert picture_shape(chart) == (60 + 9, 110 + 9)
    one, two, three = np.moveaxis(chart.corner_px, 1, 0)
    area = (two - one)[:, 0] * (three - one)[:, 1] - (two - one)[:, 1] * (three - one)[:, 0]
    np.testing.assert_allclose(area, -100)
