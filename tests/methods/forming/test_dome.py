import numpy as np
import pytest
from scipy.spatial import Delaunay

from shapemorph.core.errors import StageError
from shapemorph.methods.forming.dome import measure_dome, membrane_stress, value_at_pole


def cap(place, count=3000):
    """Disc of radius 20 mm lifted by z(x, y), turned; and its triangles."""
    rng = np.random.default_rng(5)
    flat = np.sqrt(rng.random(count))[:, None] * 20
    angle = 2 * np.pi * rng.random((count, 1))
    disc = np.concatenate([flat * np.cos(angle), flat * np.sin(angle)], axis=1)
    ring = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    disc = np.concatenate([disc, 20.05 * np.stack([np.cos(ring), np.sin(ring)], axis=1)])
    points = np.concatenate([disc, place(disc)[:, None]], axis=1)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return points @ turn.T + [30, -20, 5], Delaunay(disc).simplices


def sphere(disc):
    return np.sqrt(30.0**2 - (disc**2).sum(axis=1))


def test_a_spherical_cap_has_its_radius_and_height():
    dome = measure_dome(*cap(sphere), cap=None)
    assert dome.radius == pytest.approx(30, rel=1e-3)
    assert dome.height == pytest.approx(30 - np.sqrt(30**2 - 20.05**2), abs=2e-3)
    assert dome.rim_scatter < 1e-9
    assert dome.cap == pytest.approx(5.5, abs=0.3)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_elliptic_dome_has_two_radii_to_either_side(side):
    points, corners = cap(lambda d: side * (5 - d[:, 0] ** 2 / 80 - d[:, 1] ** 2 / 100))
    dome = measure_dome(points, corners, cap=6.0)
    np.testing.assert_allclose(1 / dome.curvatures, [40, 50], rtol=2e-3)
    assert dome.radius == pytest.approx(2 / (1 / 40 + 1 / 50), rel=2e-3)


def test_noise_of_the_radius_is_predicted():
    points, corners = cap(sphere)
    rng = np.random.default_rng(1)
    found = [
        measure_dome(points + 0.01 * rng.normal(size=points.shape), corners, cap=8.0)
        for _ in range(60)
    ]
    radii = [dome.radius for dome in found]
    assert np.mean(radii) == pytest.approx(30, abs=0.2)
    predicted = np.mean([dome.sigma_radius for dome in found])
    assert np.std(radii) == pytest.approx(predicted, rel=0.35)  # 60 draws, another pole in each


def test_a_field_is_smoothed_to_its_value_at_the_pole():
    points, corners = cap(sphere)
    dome = measure_dome(points, corners, cap=6.0)
    away = np.linalg.norm(points - points[dome.pole], axis=1)
    noise = 0.01 * np.random.default_rng(2).normal(size=len(points))
    found = value_at_pole(dome, points, 0.7 + 0.003 * away**2 + noise)
    assert found == pytest.approx(0.7, abs=0.01)


def test_stress_of_a_membrane():
    assert membrane_stress(0.8, 30.0, 0.6) == pytest.approx(20.0)


def test_a_closed_surface_is_no_dome():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    corners = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    with pytest.raises(StageError, match="closed"):
        measure_dome(points, corners, cap=None)


def test_too_small_a_cap_says_what_to_change():
    points, corners = cap(sphere)
    with pytest.raises(StageError, match=r"raise forming\.cap"):
        measure_dome(points, corners, cap=0.5)
