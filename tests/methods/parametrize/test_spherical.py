"""Spherical maps against the closed forms of map projections."""

import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.methods.distortion import singular_values
from shapemorph.methods.parametrize.round_fit import fit_round
from shapemorph.methods.parametrize.spherical import parametrise_spherical

LAWS = {
    "equidistant": lambda angle: angle,
    "equal_area": lambda angle: 2 * np.sin(angle / 2),
    "stereographic": lambda angle: 2 * np.tan(angle / 2),
}


def flatten(points, faces, projection="equidistant", centre=None, axis=None):
    return parametrise_spherical(points, faces, centre=centre, axis=axis, projection=projection)


@pytest.mark.parametrize("projection", LAWS)
@pytest.mark.parametrize("half_angle", [0.3, np.pi / 2, 2.9])
@pytest.mark.parametrize("scale", [2.5, 1500.0])
def test_distances_from_the_middle_follow_the_law(
    ball_cap, anywhere, projection, half_angle, scale
):
    points, faces, polar = ball_cap(half_angle)
    plane = flatten(anywhere(points, scale), faces, projection)
    found = np.linalg.norm(plane, axis=1) / scale
    # round-off of a sphere fit to a shallow cap, magnified by 1 / angle
    np.testing.assert_allclose(found, LAWS[projection](polar), atol=1e-8)
    assert singular_values(anywhere(points, scale), faces, plane).flips == 0


def test_equal_area_keeps_areas_and_stereographic_keeps_angles(ball_cap, anywhere):
    points, faces, polar = ball_cap(1.9, count=60)
    space = anywhere(points, 30.0)
    equal = singular_values(space, faces, flatten(space, faces, "equal_area"))
    ratio = equal.sigma_1 * equal.sigma_2
    # a facet lies below the ball by up to 1.5e-4 of its area; single ones near the rim, where
    # the map bends, are off by a hundredth, larger and smaller in turn
    np.testing.assert_allclose(ratio, 1.0, atol=0.02)
    assert np.average(ratio, weights=equal.area) == pytest.approx(1.0, abs=5e-4)
    # a facet spans 0.032 of a map whose scale changes by tan(polar / 2) per radian
    angles = singular_values(space, faces, flatten(space, faces, "stereographic"))
    inner = polar[faces].max(axis=1) < 1.5
    np.testing.assert_allclose((angles.sigma_1 / angles.sigma_2)[inner], 1.0, atol=0.02)


def test_noise_and_holes_hardly_move_the_map(ball_cap, anywhere):
    points, faces, polar = ball_cap(1.4, count=50)
    middle = points[faces].mean(axis=1)
    kept = faces[np.linalg.norm(middle - [0.7, 0.1, 0.7], axis=1) > 0.25]
    used, renamed = np.unique(kept, return_inverse=True)
    space = anywhere(points, noise=2e-4)[used]
    plane = flatten(space, renamed.reshape(-1, 3), centre=anywhere(np.zeros((1, 3)))[0])
    radial = np.linalg.norm(plane - plane[0], axis=1)
    # the hole moves the middle; about the pole, distances stay
    assert np.ptp(radial - polar[used]) < 2 * np.linalg.norm(plane[0]) + 2e-3


def test_the_sphere_is_found_although_part_of_the_surface_leaves_it(ball_cap):
    points, _, polar = ball_cap(1.5)
    skirt = polar > 1.35
    bent = points + np.where(skirt, 0.3 * (polar - 1.35), 0.0)[:, None] * [1.0, 1.0, 0.0]
    centre, weights = fit_round(bent, np.ones(len(bent)))
    assert np.linalg.norm(centre) < 1e-3
    assert weights[polar > 1.45].max() == 0


def test_a_flat_sheet_is_a_ball_of_a_thousand_times_its_size(revolve, anywhere):
    points, faces, way, _ = revolve(lambda way: (way, 0 * way))
    for projection in LAWS:
        plane = flatten(anywhere(points), faces, projection)
        np.testing.assert_allclose(np.linalg.norm(plane, axis=1), way, atol=1e-6)


def test_the_picture_shows_the_outer_side_of_a_dome_and_of_a_bowl(ball_cap, anywhere):
    points, faces, _ = ball_cap(1.0)
    for outward in (faces, faces[:, ::-1]):
        space = anywhere(points)
        assert singular_values(space, outward, flatten(space, outward)).flips == 0


def test_a_given_axis_is_the_middle_of_the_picture(ball_cap):
    points, faces, _ = ball_cap(1.2)
    axis = np.array([0.3, -0.2, 1.0])
    plane = flatten(points, faces, centre=np.zeros(3), axis=axis)
    angle = np.arccos((points @ axis / np.linalg.norm(axis)).clip(-1, 1))
    np.testing.assert_allclose(np.linalg.norm(plane, axis=1), angle, atol=1e-7)


def test_up_is_y_for_a_viewer_along_z(ball_cap):
    points, faces, _ = ball_cap(0.8)
    plane = flatten(points, faces, centre=np.zeros(3), axis=np.array([0, 0, 2.0]))
    direction = points[1:, :2] / np.linalg.norm(points[1:, :2], axis=1)[:, None]
    found = plane[1:] / np.linalg.norm(plane[1:], axis=1)[:, None]
    np.testing.assert_allclose(found, direction, atol=1e-12)


def test_a_surface_that_covers_the_far_pole_is_refused_with_advice(ball_cap):
    points, faces, _ = ball_cap(2.9)
    with pytest.raises(DataError, match=r"set flatten\.axis to point away from a hole"):
        flatten(points, faces, axis=np.array([0.0, 0.0, -1.0]))
