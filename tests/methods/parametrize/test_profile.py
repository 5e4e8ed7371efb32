"""Meridian lengths come out as the radius in the picture."""

import numpy as np
import pytest

from shapemorph.methods.distortion import singular_values
from shapemorph.methods.parametrize.profile import follow, lay_meridian, parametrise_profile
from shapemorph.methods.parametrize.revolution_axis import fit_revolution_axis

CAP, WALL = np.pi / 2, 0.43


def dome(way):
    """A half ball of radius 1 on a wall; arc length is `way` times its whole length."""
    arc = way * (CAP + WALL)
    polar = np.minimum(arc, CAP)
    return np.sin(polar), np.cos(polar) - np.maximum(arc - CAP, 0.0)


def bulge(way):
    """A paraboloid, and its arc length in closed form."""
    return way, 1.0 - 0.9 * way**2


def bulge_arc(r):
    slope = 1.8 * r
    return 0.5 * r * np.hypot(1, slope) + np.arcsinh(slope) / 3.6  # integral of sqrt(1 + slope^2)


def flatten(points, faces, centre=None, axis=None, meridian=None):
    return parametrise_profile(points, faces, centre=centre, axis=axis, meridian=meridian)


@pytest.mark.parametrize("scale", [2.5, 1500.0])
def test_radii_are_the_arc_of_a_bulge(revolve, anywhere, scale):
    points, faces, way, _ = revolve(bulge)
    plane = flatten(anywhere(points, scale), faces)
    # chords of 40 rings
    np.testing.assert_allclose(np.linalg.norm(plane, axis=1) / scale, bulge_arc(way), atol=2e-4)
    assert singular_values(anywhere(points, scale), faces, plane).flips == 0


def test_radii_are_the_arc_of_a_dome_with_an_upright_wall(revolve, anywhere):
    points, faces, way, azimuth = revolve(dome, 60)
    plane = flatten(anywhere(points), faces)
    np.testing.assert_allclose(np.linalg.norm(plane, axis=1), way * (CAP + WALL), atol=3e-4)
    turned = np.unwrap(np.arctan2(*plane[-360:].T[::-1]))
    np.testing.assert_allclose(turned - turned[0], azimuth[-360:], atol=1e-6)


def test_noise_of_the_vertices_averages_out_along_the_meridian(revolve, anywhere):
    points, faces, way, _ = revolve(dome, 60)
    off = np.linalg.norm(flatten(anywhere(points, noise=1e-3), faces), axis=1)
    error = off - way * (CAP + WALL)
    # noise of 3 % of an edge makes the surface rougher, and so its meridians longer, by half
    # the square of the slopes: 1e-3 of 2; each vertex keeps its own noise besides
    assert 0 < error.mean() < 1.5e-3
    assert error.std() < 1.3e-3


@pytest.mark.parametrize("shape", [dome, bulge])
def test_the_axis_is_found_although_a_side_of_the_rim_is_missing(revolve, anywhere, shape):
    points, faces, _, _ = revolve(shape, 50)
    kept = faces[(points[faces] @ [0.6, 0.1, -0.5]).max(axis=1) < 0.35]
    used, renamed = np.unique(kept, return_inverse=True)
    space = anywhere(points, noise=2e-4)
    centre, axis = fit_revolution_axis(space[used], renamed.reshape(-1, 3), centre=None, axis=None)
    origin, along = anywhere(np.array([[0.0, 0, 0], [0, 0, 1]]))
    true = along - origin
    assert np.linalg.norm(np.cross(axis, true)) < 2e-3
    assert np.linalg.norm(np.cross(centre - origin, true)) < 2e-3


def test_an_open_middle_is_counted_as_flat(revolve, anywhere):
    points, faces, way, _ = revolve(lambda way: (0.4 + way, 1.0 - 0.7 * way))
    kept = faces[way[faces].min(axis=1) > 0.2]
    used, renamed = np.unique(kept, return_inverse=True)
    plane = flatten(anywhere(points)[used], renamed.reshape(-1, 3))
    first = 0.4 + way[used].min()
    expected = first + np.hypot(1, 0.7) * (way[used] - way[used].min())
    np.testing.assert_allclose(np.linalg.norm(plane, axis=1), expected, atol=2e-3)


def test_a_flat_disk_stays_as_it_is(revolve, anywhere):
    points, faces, way, _ = revolve(lambda way: (way, 0 * way))
    plane = flatten(anywhere(points), faces)
    np.testing.assert_allclose(np.linalg.norm(plane, axis=1), way, atol=1e-9)


def test_a_given_meridian_is_shifted_and_turned_onto_the_surface(revolve, anywhere):
    points, faces, way, _ = revolve(dome, 60)
    r, z = dome(np.linspace(0, 1, 400))
    plane = flatten(anywhere(points), faces, meridian=np.stack([r, 7.0 - z], axis=1))
    # a polyline of 400 corners; the axis and the shift are fitted
    np.testing.assert_allclose(np.linalg.norm(plane, axis=1), way * (CAP + WALL), atol=2e-3)


def test_a_crude_meridian_still_gives_a_map_without_folds(revolve, anywhere):
    points, faces, _, _ = revolve(dome, 60)
    r, z = dome(np.linspace(0, 1, 400))
    space = anywhere(points)
    plane = flatten(space, faces, meridian=np.stack([r, 0.7 * z], axis=1))
    stretch = singular_values(space, faces, plane)
    assert stretch.area[stretch.sigma_2 <= 0].sum() < 0.01 * stretch.area.sum()


def test_a_meridian_is_laid_where_it_fits_best():
    r = np.linspace(0, 1, 200)
    points = np.stack([r, -0.5 * r**2 + 3.0], axis=1)
    laid = lay_meridian(np.stack([r, 0.5 * r**2], axis=1), points, np.ones(200))
    np.testing.assert_allclose(laid.points, points, atol=2e-3)


def test_it_is_shown_from_outside_and_from_inside(revolve, anywhere):
    points, faces, _, _ = revolve(bulge)
    space = anywhere(points)
    for side in (faces, faces[:, ::-1]):
        assert singular_values(space, side, flatten(space, side)).flips == 0


def hat(way):
    """A flat top, an upright wall and a flat flange."""
    r = np.where(way < 0.5, way, np.maximum(0.5, 2 * way - 1.0))
    return r, -np.clip(2 * way - 1.0, 0.0, 0.5)


def test_right_angles_do_not_bunch_the_map(revolve, anywhere):
    points, faces, _, _ = revolve(hat, 60)
    space = anywhere(points, noise=2e-4)
    stretch = singular_values(space, faces, flatten(space, faces))
    # along meridians 1, around the axis more; a ring of faces is 0.017 to 0.033 wide, and the
    # mean of two slopes at a corner costs each side a little
    low, high = np.quantile(stretch.sigma_2, [0.005, 0.995])
    assert low > 0.95
    assert high < 1.05


def test_a_given_way_is_followed_smoothly_and_never_backwards():
    rng = np.random.default_rng(0)
    way = np.sort(rng.uniform(0, 2, 20_000))
    smooth = 0.8 * way + 0.1 * np.sin(3 * way)
    found = follow(way, smooth + rng.normal(0, 0.02, len(way)), np.ones(len(way)))
    # rings of 333 points: 0.02 / sqrt(333) = 1.1e-3 at each, at the first one also its slope
    np.testing.assert_allclose(found, smooth, atol=8e-3)
    backwards = follow(way, np.where(way < 1, way, 2 - way), np.ones(len(way)))
    assert np.diff(backwards).min() > 0
