import numpy as np
import pytest

from shapemorph.core.camera import Camera
from shapemorph.core.errors import DataError
from shapemorph.methods.cameras.closed_form import (
    decompose_projection,
    fit_homography,
    fit_projection,
    pose_of_plane,
    pose_of_points,
    zhang_matrix,
)


@pytest.fixture(scope="module")
def pinhole():
    return Camera((1000, 800), np.array([1500.0, 1480.0]), np.array([510.0, 390.0]))


@pytest.fixture(scope="module")
def pictures(pinhole, board, board_poses):
    poses = board_poses(5)
    return poses, [
        fit_homography(board.points[:, :2], pinhole.project(pose.apply(board.points)))
        for pose in poses
    ]


def test_zhang_finds_the_matrix_from_exact_pictures(pinhole, pictures):
    found = zhang_matrix(pictures[1], pinhole.size)
    np.testing.assert_allclose(found, pinhole.matrix, rtol=1e-6, atol=1e-3)


def test_two_pictures_give_the_focal_length_of_square_pixels_about_the_middle(board, board_poses):
    square = Camera((1000, 800), np.array([1500.0, 1500.0]), np.array([499.5, 399.5]))
    plane = board.points[:, :2]
    pictures = [
        fit_homography(plane, square.project(pose.apply(board.points))) for pose in board_poses(2)
    ]
    np.testing.assert_allclose(zhang_matrix(pictures, square.size), square.matrix, rtol=1e-6)


def test_the_place_of_a_plane(pinhole, pictures):
    for pose, homography in zip(*pictures, strict=True):
        found = pose_of_plane(homography, pinhole.matrix)
        np.testing.assert_allclose(found.rotation, pose.rotation, atol=1e-7)
        np.testing.assert_allclose(found.translation, pose.translation, atol=1e-4)


def test_the_direct_linear_transform_splits_into_camera_and_place(pinhole, board_poses):
    points = np.random.default_rng(0).uniform(-20, 20, (12, 3))
    pose = board_poses(1)[0]
    pixels = pinhole.project(pose.apply(points))
    matrix, found = decompose_projection(fit_projection(points, pixels))
    np.testing.assert_allclose(matrix, pinhole.matrix, rtol=1e-5, atol=1e-2)
    np.testing.assert_allclose(found.translation, pose.translation, atol=1e-3)
    placed = pose_of_points(points, pinhole.normalised(pixels))
    np.testing.assert_allclose(placed.rotation, pose.rotation, atol=1e-7)


def test_refuses_too_few_points_and_planes():
    with pytest.raises(DataError, match="at least 4"):
        fit_homography(np.zeros((3, 2)), np.zeros((3, 2)))
    flat = np.random.default_rng(0).uniform(-1, 1, (10, 3)) * [1, 1, 0]
    with pytest.raises(DataError, match="got a plane"):
        fit_projection(flat, flat[:, :2])
