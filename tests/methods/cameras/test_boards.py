import numpy as np
import pytest

from shapemorph.core.camera import Camera
from shapemorph.core.errors import ConfigError
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.cameras.boards import (
    asymmetric_target,
    charuco_board,
    charuco_target,
    find_charuco,
    find_chessboard,
    find_dot_grid,
    grid_target,
)
from shapemorph.methods.cameras.dot_bias import middle_of_dots
from shapemorph.methods.synthetic.photographs import (
    Exposure,
    Film,
    chessboard_pattern,
    photograph_dots,
    photograph_plane,
    picture_pattern,
)

EXPOSURE = Exposure(samples=9, blur=0.6, noise=1.0, seed=0)


@pytest.fixture(scope="module")
def film():
    return Film(
        Camera(
            (600, 450),
            np.array([900.0, 905.0]),
            np.array([305.0, 220.0]),
            radial=np.array([-0.15, 0.1, 0.0]),
        )
    )


@pytest.fixture(scope="module")
def pose(board_poses):
    """A tilted board about 230 mm away, its middle near the axis."""
    rotation = board_poses(3)[2].rotation
    return lambda middle: RigidTransform(rotation, np.array([0, 0, 230.0]) - rotation @ middle)


def seen(film, place, target):
    own = place.apply(target.points)
    normals = np.tile(place.rotation[:, 2], (len(own), 1))
    flat = middle_of_dots(own, normals, np.full(len(own), target.dot_radius))
    depth = np.ones((len(own), 1))
    return film.camera.project(np.concatenate([flat, depth], axis=1))


def test_chessboard(film, pose):
    target = grid_target("board", 9, 6, 10.0, dot=0.0)
    place = pose(target.points.mean(axis=0))
    picture = photograph_plane(film, place, chessboard_pattern(9, 6, 10.0), EXPOSURE)
    error = find_chessboard(picture, 9, 6) - seen(film, place, target)
    assert np.sqrt((error**2).mean()) < 0.03
    assert not target.symmetries


@pytest.mark.parametrize("asymmetric", [False, True])
def test_dot_grids(film, pose, asymmetric):
    make, size = (asymmetric_target, (4, 9)) if asymmetric else (grid_target, (8, 6))
    target = make("dots", *size, 10.0, dot=5.0)
    place = pose(target.points.mean(axis=0))
    picture = photograph_dots(film, place, target, EXPOSURE)
    found = find_dot_grid(picture, *size, asymmetric=asymmetric, dark=True)
    expected = seen(film, place, target)
    error = min((found - expected, found[::-1] - expected), key=lambda e: np.abs(e).max())
    assert np.sqrt((error**2).mean()) < 0.03
    assert len(target.symmetries) == 1  # the half turn


def test_charuco_with_a_hidden_corner(film, pose):
    board = charuco_board(7, 5, 12.0, 9.0, "DICT_4X4_50")
    target = charuco_target("charuco", board)
    place = pose(target.points.mean(axis=0))
    printed = board.generateImage((7 * 120, 5 * 120), marginSize=0).astype(np.float32) / 255
    pattern = picture_pattern(printed, 10.0)
    picture = photograph_plane(film, place, pattern, EXPOSURE)
    x, y = seen(film, place, target)[0].astype(int)
    picture[max(y - 40, 0) : y + 25, max(x - 40, 0) : x + 25] = 0.5
    ids, pixels = find_charuco(picture, board)
    assert 0 not in ids
    assert len(ids) > 15
    error = pixels - seen(film, place, target)[ids]
    apart = np.linalg.norm(pixels - (x, y), axis=1) > 70  # windows of nearer ones hold the patch
    assert np.sqrt((error[apart] ** 2).mean()) < 0.04


def test_nothing_is_found_where_nothing_is():
    blank = np.full((200, 300), 0.6, dtype=np.float32)
    assert find_chessboard(blank, 9, 6) is None
    assert find_dot_grid(blank, 5, 4, asymmetric=False, dark=True) is None
    assert find_charuco(blank, charuco_board(7, 5, 12.0, 9.0, "DICT_4X4_50")) is None


def test_boards_that_cannot_be_are_refused():
    with pytest.raises(ConfigError, match="dictionary 'NONE' is unknown"):
        charuco_board(7, 5, 12.0, 9.0, "NONE")
    with pytest.raises(ConfigError, match="does not fit"):
        charuco_board(7, 5, 12.0, 13.0, "DICT_4X4_50")
