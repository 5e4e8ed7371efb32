import cv2
import numpy as np

from shapemorph.methods.cameras.dot_bias import middle_of_dots


def test_agrees_with_an_ellipse_through_the_outline():
    centre, radius = np.array([30.0, -20.0, 300.0]), 8.0
    normal = np.array([0.5, 0.3, -0.8])
    normal /= np.linalg.norm(normal)
    across = np.cross(normal, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)[:, None]
    rim = centre + radius * (np.cos(angle) * across + np.sin(angle) * np.cross(normal, across))
    outline = rim[:, :2] / rim[:, 2:]
    # scaled up: the fit works in single precision
    (x, y), _, _ = cv2.fitEllipseDirect(((outline - outline.mean(axis=0)) * 1e5).astype(np.float32))
    expected = np.array([x, y]) / 1e5 + outline.mean(axis=0)
    found = middle_of_dots(centre[None], normal[None], np.array([radius]))[0]
    np.testing.assert_allclose(found, expected, atol=2e-7)
    assert np.linalg.norm(found - centre[:2] / centre[2]) > 5e-5


def test_a_dot_of_no_size_is_seen_where_its_middle_is():
    centre = np.array([[3.0, 4.0, 10.0]])
    normal = np.array([[0.0, 0.6, 0.8]])
    np.testing.assert_allclose(middle_of_dots(centre, normal, np.zeros(1)), [[0.3, 0.4]])


def test_a_dot_behind_the_camera_is_not_seen():
    behind = np.array([[0.0, 0.0, -10.0]])
    assert np.isnan(middle_of_dots(behind, np.array([[0.0, 0.0, 1.0]]), np.ones(1))).all()
