import numpy as np

from shapemorph.methods.variant_differences import carried_over


def sphere_points(rng, count, spread=0.6):
    """Points of a sphere of 20 mm around its pole, and their normals."""
    angle = 2 * np.pi * rng.random(count)
    away = spread * np.sqrt(rng.random(count))
    normals = np.stack(
        [np.sin(away) * np.cos(angle), np.sin(away) * np.sin(angle), np.cos(away)], axis=1
    )
    return 20 * normals, normals


def field(points):
    """Smooth values that no plane follows."""
    x, y, z = points.T
    return np.stack([x * y / 20, z, np.sin(x / 6)], axis=1)


def test_smooth_values_on_a_curved_surface_arrive_from_another_grid():
    rng = np.random.default_rng(3)
    places, normals = sphere_points(rng, 300, spread=0.5)
    others, _ = sphere_points(rng, 4000)
    found = carried_over(places, normals, others, field(others))
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found, field(places), atol=2e-3)


def test_points_beyond_the_other_measurement_get_nothing():
    rng = np.random.default_rng(4)
    places, normals = sphere_points(rng, 300, spread=0.9)
    others, _ = sphere_points(rng, 3000, spread=0.5)
    found = carried_over(places, normals, others, field(others))
    away = np.arccos(normals[:, 2])
    assert np.isnan(found[away > 0.52]).all()
    assert np.isfinite(found[away < 0.45]).all()


def test_too_few_points_say_nothing():
    places, normals = sphere_points(np.random.default_rng(5), 10)
    assert np.isnan(carried_over(places, normals, places, field(places))).all()
