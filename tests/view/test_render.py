import ctypes.util
import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.core.errors import StageError
from shapemorph.core.mesh import coloured_mesh, textured_mesh
from shapemorph.view import render
from shapemorph.view.camera import View
from shapemorph.view.render import Scene, joined_corners
from shapemorph.view.style import ColourScale

FROM_ABOVE = View(np.array([0.0, 0, 1]), np.array([0.0, 1, 0]))
SQUARE = np.array([[0.0, 0, 0], [3, 0, 0], [3, 2, 0], [0, 2, 0]])
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


@pytest.fixture(scope="module")
def scene():
    if sys.platform.startswith("linux") and not all(
        ctypes.util.find_library(name) for name in ("EGL", "GL")
    ):
        pytest.skip("libEGL or libGL is not installed: `make setup` names the command")
    with Scene() as scene:
        yield scene


def _shot(scene):
    frame = scene.frame(FROM_ABOVE, width=240, height=240)
    return scene.picture(FROM_ABOVE, frame)


@pytest.mark.render
def test_texture_stands_upright_and_by_its_wedges(scene):
    texture = np.ones((40, 60), dtype=np.float32)
    texture[:20, :30] = 0.0  # dark: upper left quarter
    mesh = textured_mesh(
        SQUARE, HALVES, (SQUARE[:, :2] / [3, 2])[HALVES], np.zeros(2, int), (texture,), name="flag"
    )
    scene.clear("flag")
    scene.add_textured(mesh)
    pixels = _shot(scene).pixels.mean(axis=-1)
    height, width = pixels.shape
    dark = pixels[height // 4, width // 4]
    light = [
        pixels[row * height // 4, column * width // 4] for row, column in [(1, 3), (3, 1), (3, 3)]
    ]
    assert dark < 30
    assert min(light) > 200


@pytest.mark.render
def test_grey_of_corners_is_interpolated_across_a_face(scene):
    corners = (SQUARE[:, 0] / 3)[HALVES]
    scene.clear("ramp")
    scene.add_textured(coloured_mesh(SQUARE, HALVES, corners, name="ramp"))
    row = _shot(scene).pixels[80, 20:-20, 0].astype(float)
    assert (np.diff(row) >= -1).all()
    assert row[-1] - row[0] > 180


@pytest.mark.render
def test_colours_of_a_field_are_those_of_its_scale(scene):
    scene.clear("field")
    painter = scene.add_coloured(SQUARE, np.array([[0, 1, 2, 3]]))
    scale = ColourScale("viridis", 0.0, 2.0, "neither")
    painter.paint(np.full(4, 1.0), scale)
    middle = _shot(scene).pixels[60, 120].astype(float)
    wanted = scale.colours(np.array([1.0]))[0].astype(float)
    # light from the front keeps the hue and all but all of the lightness
    assert_allclose(middle, wanted, atol=12)
    painter.paint(np.full(4, 2.0), scale)
    assert np.abs(_shot(scene).pixels[60, 120].astype(float) - middle).max() > 60


@pytest.mark.render
def test_bare_surface_shows_only_where_there_is_no_value(scene):
    scene.clear("half")
    left = SQUARE * [0.5, 1, 1]
    scene.add_coloured(left, np.array([[0, 1, 2, 3]])).paint(
        np.zeros(4), ColourScale("viridis", 0.0, 1.0, "neither")
    )
    scene.add_bare(SQUARE, HALVES)
    frame = scene.frame(FROM_ABOVE, width=240, height=240)
    pixels = scene.picture(FROM_ABOVE, frame).pixels.astype(int)
    assert np.ptp(pixels[100, 90]) > 40  # coloured
    assert frame.mm_per_px == pytest.approx(2 * 1.06 / 240)


@pytest.mark.render
def test_a_picture_keeps_its_scale(scene):
    scene.clear("square")
    scene.add_coloured(SQUARE, np.array([[0, 1, 2, 3]])).paint(
        np.zeros(4), ColourScale("viridis", 0.0, 1.0, "neither")
    )
    shot = _shot(scene)
    covered = (shot.pixels.sum(axis=-1) < 600).any(axis=0).sum()
    assert covered * shot.mm_per_px == pytest.approx(3.0, abs=2.5 * shot.mm_per_px)


@pytest.mark.render
def test_nothing_in_the_picture_is_an_error_that_names_the_doctor(scene):
    scene.clear("a plate")
    scene.add_coloured(SQUARE, np.array([[0, 1, 2, 3]]))
    frame = scene.frame(FROM_ABOVE, width=120, height=120)
    away = View(np.array([0.0, 0, 1]), np.array([0.0, 1, 0]))
    aside = np.array([100.0, 0, 0])
    lost = render.Frame(frame.centre + aside, 120, 120, frame.mm_per_px)
    with pytest.raises(StageError, match=r"a plate, got a blank one: run `shapemorph doctor`"):
        scene.picture(away, lost)


def test_corners_are_one_point_where_vertex_and_place_in_the_texture_agree():
    uv = (SQUARE[:, :2] / [3, 2])[HALVES]
    uv[1, 1] += 0.25  # a seam at one corner of the second face
    mesh = textured_mesh(
        SQUARE, HALVES, uv, np.zeros(2, int), (np.ones((4, 4), np.float32),), name="seam"
    )
    points, places, faces = joined_corners(mesh, np.array([True, True]))
    assert len(points) == 5
    assert_allclose(points[faces], SQUARE[HALVES])
    assert_allclose(places[faces], uv)
