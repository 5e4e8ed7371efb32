"""A morph between pictures that are turned against each other keeps its size."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import ndimage

from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.methods.coarse_grid import Middle, carry_by_warp
from shapemorph.methods.morph_sequence import morph_sequence
from shapemorph.methods.sequence_steps import follow_points, images_for_strain
from shapemorph.methods.sequence_turn import NO_TURN, Turn, turn_between
from shapemorph.methods.warping import warp_points

CENTRE = np.array([80.0, 70.0])
SHIFT = np.array([3.0, -2.0])
STRETCH = np.diag([1.2, 0.9])


def _rotation(degrees):
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[cosine, -sine], [sine, cosine]])


def _warp(matrix, shift):
    rows, columns = np.mgrid[-4:15, -4:15].astype(float)
    nodes = 15.0 * np.stack([columns, rows], axis=-1)
    return Warp(nodes @ matrix.T + shift, np.array([-60.0, -60.0]), 15.0)


def _warps(degrees, stretch=STRETCH):
    """A stretch about the centre, then a turn about it and a shift by (3, -2)."""
    matrix = _rotation(degrees) @ stretch
    shift = CENTRE + SHIFT - matrix @ CENTRE
    inverse = np.linalg.inv(matrix)
    return _warp(matrix, shift), _warp(inverse, -inverse @ shift)


def _points():
    rows, columns = np.mgrid[-30:31:10, -30:31:10].astype(float)
    return CENTRE + np.stack([columns.ravel(), rows.ravel()], axis=-1)


@pytest.mark.parametrize("degrees", [40.0, -90.0, 170.0])
def test_the_turn_of_a_turned_picture_is_found(degrees):
    turn = turn_between(_points(), _warps(degrees, np.eye(2))[0])
    assert np.degrees(turn.angle) == pytest.approx(degrees, abs=1e-9)
    assert_allclose(turn.end - turn.start, SHIFT, atol=1e-9)
    whole = turn.carry(_points(), 1.0)
    assert_allclose(whole, warp_points(_warps(degrees, np.eye(2))[0], _points())[0], atol=1e-9)
    assert_allclose(turn.undo(turn.carry(_points(), 0.3), 0.3), _points(), atol=1e-9)
    assert_allclose(turn.back.carry(whole, 1.0), _points(), atol=1e-9)


def test_a_small_turn_is_left_to_straight_ways():
    assert turn_between(_points(), _warps(29.0, np.eye(2))[0]) is NO_TURN


@pytest.mark.parametrize("degrees", [40.0, 170.0])
def test_half_way_is_half_the_stretch_and_half_the_turn_from_both_sides(degrees):
    warps, points = _warps(degrees), _points()
    turn = turn_between(points, warps[0])
    followed = follow_points(points, *warps, images=4, turn=turn)
    half = _rotation(np.degrees(turn.angle) / 2) @ (
        np.eye(2) + _rotation(-np.degrees(turn.angle)) @ _rotation(degrees) @ STRETCH
    )
    expected = CENTRE + SHIFT / 2 + (points - CENTRE) @ (half / 2).T
    assert_allclose(followed.positions[2], expected, atol=1e-8)
    assert_allclose(followed.positions[3], expected, atol=1e-8)
    assert followed.strain[2] == pytest.approx(0.0, abs=1e-8)


def test_a_rigid_turn_strains_nothing_but_by_turning():
    warps = _warps(120.0, np.eye(2))
    followed = follow_points(_points(), *warps, images=12, turn=turn_between(_points(), warps[0]))
    expected = np.r_[
        np.full(6, 2 * np.sin(np.radians(5.0))), 0, np.full(6, 2 * np.sin(np.radians(5.0)))
    ]
    assert_allclose(followed.strain, expected, atol=1e-8)


def test_a_turn_of_half_a_circle_needs_no_more_pictures_than_its_angle_asks_for():
    warps = _warps(180.0 - 1e-6, np.eye(2))
    turn = turn_between(_points(), warps[0])
    assert abs(turn.angle) == pytest.approx(np.pi, abs=1e-6)
    found = images_for_strain(_points(), warps, turn, most_strain=0.15, most_images=40)
    assert found == 22  # 180 / 22 = 8.2 degrees = 0.143
    assert images_for_strain(_points(), warps, NO_TURN, most_strain=0.15, most_images=40) == 40


def _pictures(warps):
    rows, columns = np.mgrid[0:140, 0:160].astype(float)
    places = np.stack([columns, rows], axis=-1).reshape(-1, 2)
    material = warp_points(warps[1], places)[0]

    def shown(at):
        inside = np.hypot(*(at - CENTRE).T).reshape(140, 160) < 45
        grey = 0.5 + 0.2 * np.sin(0.39 * at[:, 0] + 0.2 * at[:, 1]) + 0.2 * np.cos(0.31 * at[:, 1])
        return GreyImage(np.where(inside, grey.reshape(140, 160), 0).astype("f4"), inside)

    return shown(places), shown(material)


def test_the_middle_pictures_of_a_turned_pair_agree_and_are_not_shrunk():
    warps = _warps(150.0)
    turn = turn_between(_points(), warps[0])
    pictures = _pictures(warps)
    frames = list(morph_sequence(*pictures, *warps, images=4, turn=turn))
    both = ndimage.binary_erosion(frames[1].mask & frames[2].mask, iterations=5)
    assert both.sum() > 4000
    # Both were sampled once from pictures that end sharply at their rims.
    assert_allclose(frames[1].grey[both], frames[2].grey[both], atol=6e-3)
    areas = [picture.mask.sum() for picture in (pictures[0], *frames, pictures[1])]
    assert min(areas) > 0.97 * areas[0]  # on straight ways a fifteenth of it is left


@pytest.mark.parametrize("turned", [True, False])
def test_points_of_the_middle_are_carried_out_as_the_pictures_were_moved(turned):
    warps, points = _warps(60.0), _points()
    turn = turn_between(points, warps[0]) if turned else NO_TURN
    followed = follow_points(points, *warps, images=4, turn=turn)
    middle = Middle(followed.positions[2], followed.positions[3], None)
    carried = carry_by_warp(middle, warps, images=4, turn=turn)
    assert_allclose(carried[:, 0], points, atol=1e-3)
    assert_allclose(carried[:, 1], warp_points(warps[0], points)[0], atol=1e-3)


def test_parts_of_no_turn_leave_points_where_they_are():
    assert isinstance(NO_TURN, Turn)
    assert_allclose(NO_TURN.carry(_points(), 0.7), _points())
