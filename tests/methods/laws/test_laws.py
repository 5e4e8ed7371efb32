"""Laws that are fed with the truth of a closed-form map give that map back."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.core.errors import StageError
from shapemorph.core.laws import NodalField, RadialProfile
from shapemorph.methods.laws.finite_elements import interpolated, place_field, place_profile
from shapemorph.methods.laws.identity import rigid_warp
from shapemorph.methods.laws.landmarks import on_a_line, profile_of_dots
from shapemorph.methods.laws.polynomial import fit_polynomial_law
from shapemorph.methods.laws.radial import RadialPose, law_pairs, rotate
from shapemorph.methods.warping import warp_points

POSE = RadialPose(np.array([31.0, 24.0]), np.array([44.0, 40.0]), 0.7)
TRUE = np.array([0.8, -4e-3, -8e-5])  # r_m of rho, mm


def _profile(radius):
    return TRUE[0] * radius + TRUE[1] * radius**2 + TRUE[2] * radius**3


def _pairs(count=700, seed=3):
    """Reference and deformed points, mm, denser on one side."""
    rng = np.random.default_rng(seed)
    angle, radius = rng.uniform(-np.pi, 2.0, count), 30 * np.sqrt(rng.uniform(0, 1, count))
    deformed = POSE.deformed_centre + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1)
    return POSE.carry(deformed, _profile), deformed


def test_a_turn_goes_from_x_towards_y():
    assert_allclose(rotate(np.array([[2.0, 0.0]]), 0.3), [[2 * np.cos(0.3), 2 * np.sin(0.3)]])


def test_the_carried_direction_is_the_old_one_turned():
    reference, deformed = _pairs()
    away = rotate(deformed - POSE.deformed_centre, 0.7)
    there = reference - POSE.reference_centre
    assert np.abs(away[:, 0] * there[:, 1] - away[:, 1] * there[:, 0]).max() < 1e-10
    assert (np.sum(away * there, axis=1) > 0).all()


@pytest.mark.parametrize("order", [3, 5])
def test_a_polynomial_law_is_found_with_its_centres_and_turn(order):
    reference, deformed = _pairs()
    law = fit_polynomial_law(reference, deformed, order=order, centre=None, coefficients=None)
    radius = np.linspace(0, 30, 50)
    assert_allclose(law.profile(radius), _profile(radius), atol=1e-4)
    assert_allclose(law.pose.reference_centre, POSE.reference_centre, atol=1e-4)
    assert_allclose(law.pose.deformed_centre, POSE.deformed_centre, atol=1e-4)
    assert law.pose.turn == pytest.approx(0.7, abs=1e-6)


def test_noise_and_wrong_matches_hardly_move_a_polynomial_law():
    reference, deformed = _pairs()
    rng = np.random.default_rng(0)
    reference = reference + rng.normal(scale=0.02, size=reference.shape)
    wrong = rng.choice(len(reference), 70, replace=False)
    reference[wrong] += rng.normal(scale=5.0, size=(70, 2))
    law = fit_polynomial_law(reference, deformed, order=3, centre=None, coefficients=None)
    radius = np.linspace(0, 28, 50)
    # 630 good points of 0.02 mm fix six unknowns to a few hundredths at the rim
    assert_allclose(law.profile(radius), _profile(radius), atol=0.1)


def test_given_centre_and_coefficients_are_kept_and_the_pose_is_fitted():
    reference, deformed = _pairs()
    law = fit_polynomial_law(
        reference, deformed, order=9, centre=POSE.reference_centre, coefficients=list(TRUE)
    )
    assert law.coefficients.tolist() == TRUE.tolist()
    assert law.pose.reference_centre.tolist() == POSE.reference_centre.tolist()
    assert_allclose(law.pose.deformed_centre, POSE.deformed_centre, atol=1e-4)
    assert law.pose.turn == pytest.approx(0.7, abs=1e-6)


def test_a_law_fitted_to_too_few_matches_is_refused():
    reference, deformed = _pairs(7)
    with pytest.raises(StageError, match="needs at least 8 matches"):
        fit_polynomial_law(reference, deformed, order=3, centre=None, coefficients=None)


def test_points_beyond_the_turning_point_are_left_out():
    points = POSE.deformed_centre + np.array([[0.0, 10.0], [20.0, 0.0], [0.0, -39.0]])
    source, target = law_pairs(POSE, lambda rho: rho - rho**2 / 60, points)
    assert target.tolist() == points[:2].tolist()
    assert_allclose(np.linalg.norm(source - POSE.reference_centre, axis=1), [10 - 100 / 60, 40 / 3])
    with pytest.raises(StageError, match=r"turns back at .* lower morph\.order"):
        law_pairs(POSE, lambda rho: rho - rho**2 / 20, points)


def test_dots_on_a_diameter_give_the_law_between_them():
    deformed = POSE.deformed_centre + np.linspace(-28, 27, 40)[:, None] * np.array([0.6, 0.8])
    reference = POSE.carry(deformed, _profile)
    assert on_a_line(reference)
    profile = profile_of_dots(POSE, reference, deformed)
    radius = np.linspace(0, 27, 60)
    # dots 1.4 mm apart, seen from both sides; curvature 0.02 / mm: sagitta of some microns
    assert_allclose(profile(radius), _profile(radius), atol=0.02)
    assert profile(np.array([40.0])) > profile(np.array([28.0]))


def test_dots_whose_order_changes_are_refused():
    deformed = POSE.deformed_centre + np.array([[5.0, 0], [10.0, 0], [15.0, 0]])
    reference = POSE.reference_centre + np.array([[4.0, 0], [12.0, 0], [8.0, 0]])
    with pytest.raises(StageError, match="distance from the centre rises in both"):
        profile_of_dots(POSE, reference, deformed)


def test_scattered_dots_are_not_on_a_line():
    assert not on_a_line(np.array([[0.0, 0], [50, 3], [100, -20], [20, 30]]))


def test_nothing_deformed_is_a_turn_a_shift_and_the_two_scales():
    rng = np.random.default_rng(2)
    source = rng.uniform(0, 200, (40, 2))
    target = 1.5 * rotate(source, -2.4) + [300.0, 90.0]
    warp = rigid_warp((150, 220), source, target, scale=1.5)
    assert_allclose(warp_points(warp, source)[0], target, atol=1e-9)


def _bowl(radius):
    return 1.2 * radius - 2e-3 * radius**2, 15.0 - 0.012 * radius**2


def _turned(seed):
    matrix, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return matrix * np.linalg.det(matrix)


@pytest.mark.parametrize("up", [1.0, -1.0])
def test_a_profile_is_laid_over_both_shapes(up):
    rng = np.random.default_rng(4)
    flat = rng.uniform([-25, -18], [20, 26], (300, 2))  # not centred on the axis
    radius = np.hypot(*flat.T)
    after, height = _bowl(radius)
    deformed = np.column_stack([flat * (after / radius)[:, None], up * height])
    before = np.column_stack([flat, np.zeros(300)])
    here, there = _turned(5), _turned(6)
    before, deformed = before @ here.T + [5, 8, -3], deformed @ there.T + [90, 0, 20]
    material = np.linspace(0, 40, 81)
    profile = RadialProfile(material, *_bowl(material))
    move = place_profile(profile, before[:150], deformed[:150])
    assert_allclose(move(before[150:]), deformed[150:], atol=0.01)


def test_a_crude_profile_still_finds_the_axis():
    rng = np.random.default_rng(4)
    flat = rng.uniform(-25, 25, (400, 2))
    radius = np.hypot(*flat.T)
    after, height = _bowl(radius)
    deformed = np.column_stack([flat * (after / radius)[:, None], height])
    before = np.column_stack([flat + np.array([3.0, -2.0]), np.zeros(400)])
    material = np.linspace(0, 40, 81)
    low = RadialProfile(material, 0.9 * _bowl(material)[0], 0.7 * _bowl(material)[1])
    move = place_profile(low, before, deformed)
    apex = move(np.array([[3.0, -2.0, 0.0]]))[0]
    # a model too low by a third and too narrow by a tenth still centres to a fiftieth of 25 mm
    assert_allclose(apex[:2], 0.0, atol=0.5)


def _bend(points):
    return np.stack(
        [0.02 * points[:, 0] ** 2, 0.1 * points[:, 0] - 3.0, 0.05 * points[:, 1] ** 2], axis=1
    )


@pytest.mark.parametrize("thickness", [0.0, 2.0])
def test_a_field_without_symmetry_is_read_between_the_nodes_of_shells_and_solids(thickness):
    rng = np.random.default_rng(7)
    nodes = rng.uniform(0, 20, (4000, 3)) * [1, 1, thickness / 20]
    points = rng.uniform(2, 18, (50, 3)) * [1, 1, thickness / 20]
    found = interpolated(NodalField(nodes, _bend(nodes)))(points)
    # second differences over the reach of a dozen nodes (about 0.7 mm; a solid: 1.2 mm)
    assert_allclose(found, _bend(points), atol=0.05)


def test_a_field_is_turned_into_the_frame_of_the_deformed_file():
    rng = np.random.default_rng(8)
    nodes = np.column_stack([rng.uniform(0, 20, (3000, 2)), np.zeros(3000)])
    points = np.column_stack([rng.uniform(2, 18, (60, 2)), np.zeros(60)])
    turn = _turned(9)
    there = (points + _bend(points)) @ turn.T + [100, 50, 0]
    move = place_field(NodalField(nodes, _bend(nodes)), points[:30], there[:30])
    assert_allclose(move(points[30:]), there[30:], atol=0.05)
    alone = place_field(NodalField(nodes, _bend(nodes)), points[:0], there[:0])
    assert_allclose(alone(points), points + _bend(points), atol=0.05)
