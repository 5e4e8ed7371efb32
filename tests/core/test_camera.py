import cv2
import numpy as np
import pytest

from shapemorph.core.camera import Camera, Rig, distort, distortion_slope, undistort
from shapemorph.core.errors import DataError
from shapemorph.core.transform import RigidTransform

TURN = cv2.Rodrigues(np.array([0.2, -0.3, 0.1]))[0]


def camera(**given):
    settings = {
        "size": (1000, 800),
        "focal": np.array([1500.0, 1490.0]),
        "centre": np.array([510.0, 395.0]),
        "radial": np.array([-0.15, 0.3, -0.2]),
        "tangential": np.array([4e-4, -3e-4]),
        "pose": RigidTransform(TURN, np.array([5.0, -3.0, 400.0])),
    }
    return Camera(**{**settings, **given})


def test_projects_as_opencv_does():
    points = np.random.default_rng(0).uniform(-60, 60, (50, 3))
    shown = camera()
    lens = np.array([*shown.radial[:2], *shown.tangential, shown.radial[2]])
    pose = cv2.Rodrigues(shown.pose.rotation)[0], shown.pose.translation
    expected = cv2.projectPoints(points, *pose, shown.matrix, lens)[0][:, 0]
    np.testing.assert_allclose(shown.project(points), expected, atol=1e-9)


def test_a_ray_of_a_pixel_goes_through_the_point_seen_there():
    points = np.random.default_rng(1).uniform(-60, 60, (50, 3))
    shown = camera(skew=2.0)
    rays = shown.rays(shown.project(points))
    offset = points - shown.position
    np.testing.assert_allclose(np.cross(rays, offset), 0, atol=1e-9)
    assert ((rays * offset).sum(axis=1) > 0).all()


def test_points_behind_the_camera_are_not_seen():
    assert np.isnan(camera().project(np.array([0.0, 0.0, -500.0]))).all()


def test_undistortion_inverts_distortion_to_rounding():
    flat = np.stack(np.meshgrid(np.linspace(-0.4, 0.4, 9), np.linspace(-0.3, 0.3, 7)), axis=-1)
    radial, tangential = np.array([-0.15, 0.3, -0.2]), np.array([4e-4, -3e-4])
    found = undistort(distort(flat, radial, tangential), radial, tangential)
    np.testing.assert_allclose(found, flat, atol=1e-13)


def test_a_pixel_beyond_the_turning_radius_has_no_direction():
    radial = np.array([-0.3, 0.0, 0.0])  # r (1 - 0.3 r²) never exceeds 0.703
    bent = np.array([[0.5, 0.0], [0.71, 0.0]])
    found = undistort(bent, radial, np.zeros(2))
    assert np.isfinite(found[0]).all()
    assert np.isnan(found[1]).all()


def test_the_slope_is_the_derivative():
    at, radial, tangential = (
        np.array([0.2, -0.3]),
        np.array([-0.2, 0.1, 0.3]),
        np.array([0.01, 0.02]),
    )
    step = 1e-6 * np.eye(2)
    numeric = [
        (distort(at + d, radial, tangential) - distort(at - d, radial, tangential)) / 2e-6
        for d in step
    ]
    np.testing.assert_allclose(
        distortion_slope(at, radial, tangential), np.stack(numeric, axis=1), atol=1e-9
    )


def test_between_carries_from_the_first_frame_into_the_second():
    one, two = camera(), camera(pose=RigidTransform(TURN.T, np.array([1.0, 2.0, 300.0])))
    rig = Rig((one, two), ("left", "right"))
    point = np.array([3.0, 4.0, 5.0])
    carried = rig.between(0, 1).apply(one.pose.apply(point))
    np.testing.assert_allclose(carried, two.pose.apply(point))
    assert rig.baseline(0, 1) == pytest.approx(np.linalg.norm(rig.between(0, 1).translation))
    assert rig.stereo_angle(0, 0) == 0.0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"focal": np.array([-1.0, 1.0])}, "positive"),
        ({"radial": np.zeros(2)}, "3 finite numbers"),
        ({"size": (0, 5)}, "1 x 1 px"),
    ],
)
def test_refuses_what_is_no_camera(given, message):
    with pytest.raises(DataError, match=message):
        camera(**given)


def test_refuses_two_cameras_of_one_name():
    with pytest.raises(DataError, match="different names"):
        Rig((camera(), camera()), ("left", "left"))
