"""Matching of subsets where the answer is known on paper."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from shapemorph.core.image import GreyImage
from shapemorph.core.status import PointStatus
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import (
    SubsetSettings,
    affine_starts,
    identity_starts,
    match_points,
)

SHAPE = (90, 120)
CENTRE = np.array([60.0, 45.0])
POINTS = np.array([[40, 30], [60, 45], [75, 62], [52, 55]])


@dataclass(frozen=True)
class Case:
    """Two pictures."""

    reference: np.ndarray
    deformed: np.ndarray
    mask: np.ndarray
    other: np.ndarray

    def match(self, starts=None, points=POINTS, **changes):
        known = {"radius": 10, "order": 1, "tolerance": 1e-4, "max_iterations": 40}
        known |= {"min_inside": 0.5, "max_drift": 8.0}
        settings = SubsetSettings(**(known | changes))
        reference = prepare_reference(
            GreyImage(self.reference, self.mask), allowed=None, pad=settings.pad
        )
        deformed = prepare_deformed(GreyImage(self.deformed, self.other), pad=settings.pad)
        starts = identity_starts(len(points)) if starts is None else starts
        return match_points(reference, deformed, points, starts, settings=settings)


@pytest.fixture
def make_case(wave_pattern, pixel_grid):
    """Pictures of a pattern whose material is found at `back(pixel)`."""

    def make(back, size=5.0, gain=1.0, offset=0.0):
        pattern, pixels = wave_pattern(size), pixel_grid(SHAPE)
        full = np.ones(SHAPE, dtype=bool)
        moved = gain * pattern(back(pixels)) + offset
        return Case(pattern(pixels).astype("f4"), moved.astype("f4"), full, full)

    return make


def _affine(gradient, shift):
    inverse = np.linalg.inv(gradient)

    def forward(points):
        return (points - CENTRE) @ gradient.T + CENTRE + shift

    def back(points):
        return (points - CENTRE - shift) @ inverse.T + CENTRE

    return forward, back


GRADIENT = np.array([[1.06, 0.03], [-0.05, 0.97]])


def test_an_affine_motion_is_found_with_its_gradient(make_case):
    forward, back = _affine(GRADIENT, np.array([0.7, -1.2]))
    found = make_case(back).match()
    assert (found.status == PointStatus.OK).all()
    assert_allclose(found.position, forward(POINTS.astype(float)), atol=2e-3)
    assert_allclose(found.gradient, np.broadcast_to(GRADIENT, (4, 2, 2)), atol=5e-4)
    assert (found.zncc > 0.9999).all()


def test_gain_and_offset_of_the_grey_change_nothing(make_case):
    _, back = _affine(GRADIENT, np.array([0.4, 0.3]))
    plain, lit = make_case(back).match(), make_case(back, gain=0.4, offset=0.2).match()
    assert_allclose(lit.position, plain.position, atol=1e-4)


def test_a_large_rotation_is_found_from_a_start_nearby(make_case):
    angle = np.radians(70)
    gradient = 1.3 * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    forward, back = _affine(gradient, np.array([2.0, 1.0]))
    points = np.array([[60, 45], [55, 50]])
    where = forward(points.astype(float)) + np.array([1.0, -0.8])
    starts = affine_starts(points, where, np.broadcast_to(0.95 * gradient, (2, 2, 2)))
    found = make_case(back).match(starts, points)
    assert_allclose(found.position, forward(points.astype(float)), atol=3e-3)
    assert_allclose(found.gradient, np.broadcast_to(gradient, (2, 2, 2)), atol=1e-3)


def _bent(points):
    """A map with a second derivative of 0.006 / px."""
    local = points - CENTRE
    x, y = local[..., 0], local[..., 1]
    bend = np.stack([0.003 * x * x - 0.002 * y * y, 0.002 * x * y], axis=-1)
    return points + bend


def _bent_back(points):
    guess = points.copy()
    for _ in range(60):
        guess = guess + points - _bent(guess)
    return guess


def test_second_order_follows_a_bend_that_first_order_misses(make_case):
    case = make_case(_bent_back)
    truth = _bent(POINTS.astype(float))
    first, second = case.match(), case.match(order=2)
    assert np.abs(first.position - truth).max() > 0.05
    assert_allclose(second.position, truth, atol=3e-3)
    curvature = second.warps[:, [3, 4, 5, 9, 10, 11]]
    expected = np.broadcast_to([0.003, 0, -0.002, 0, 0.002, 0], curvature.shape)
    assert_allclose(curvature, expected, atol=3e-4)


def test_zero_order_keeps_the_gradient_of_its_start(make_case):
    forward, back = _affine(GRADIENT, np.array([0.7, -1.2]))
    truth = forward(POINTS.astype(float))
    starts = affine_starts(
        POINTS, truth + np.array([0.9, -0.7]), np.broadcast_to(GRADIENT, (4, 2, 2))
    )
    found = make_case(back).match(starts, order=0)
    assert_allclose(found.gradient, np.broadcast_to(GRADIENT, (4, 2, 2)), atol=1e-12)
    assert_allclose(found.position, truth, atol=3e-3)


def test_what_lies_outside_the_masks_does_not_matter(make_case):
    _, back = _affine(GRADIENT, np.array([0.4, 0.3]))
    case = make_case(back)
    mask, other = case.mask.copy(), case.other.copy()
    mask[:, :33] = False
    other[66:] = False
    spoiled = []
    for seed in (0, 1):
        rng = np.random.default_rng(seed)
        reference = np.where(mask, case.reference, rng.random(SHAPE)).astype("f4")
        deformed = np.where(other, case.deformed, rng.random(SHAPE)).astype("f4")
        spoiled.append(Case(reference, deformed, mask, other).match())
    assert_array_equal(spoiled[0].position, spoiled[1].position)
    assert (spoiled[0].status == PointStatus.OK).all()


def test_partial_subsets_are_right(make_case):
    forward, back = _affine(GRADIENT, np.array([0.4, 0.3]))
    case = make_case(back)
    mask = case.mask.copy()
    mask[:, :40] = False  # half of the subset of the first point is left
    found = Case(case.reference, case.deformed, mask, case.other).match(min_inside=0.4)
    assert found.status[0] == PointStatus.OK
    assert_allclose(found.position, forward(POINTS.astype(float)), atol=5e-3)


def test_too_little_of_the_subset_is_no_match(make_case):
    _, back = _affine(np.eye(2), np.zeros(2))
    case = make_case(back)
    gone = case.mask.copy()
    gone[:, :45] = False
    assert Case(case.reference, case.deformed, gone, case.other).match().status[0] == (
        PointStatus.LOW_CONTRAST
    )
    assert Case(case.reference, case.deformed, case.mask, gone).match().status[0] == (
        PointStatus.LEFT_IMAGE
    )


def test_material_that_moved_out_of_the_picture_has_left_it(make_case):
    shift = np.array([-33.0, 0.0])
    _, back = _affine(np.eye(2), shift)
    starts = affine_starts(POINTS, POINTS + shift, np.broadcast_to(np.eye(2), (4, 2, 2)))
    found = make_case(back).match(starts, min_inside=0.9)
    assert found.status[0] == PointStatus.LEFT_IMAGE


def test_a_blank_subset_has_low_contrast_on_either_side(make_case):
    _, back = _affine(np.eye(2), np.zeros(2))
    case = make_case(back)
    blank = np.full(SHAPE, 0.5, dtype="f4")
    for reference, deformed in ((blank, case.deformed), (case.reference, blank)):
        found = Case(reference, deformed, case.mask, case.other).match()
        assert (found.status == PointStatus.LOW_CONTRAST).all()


def test_foreign_material_is_never_called_a_good_match(make_case, wave_pattern, pixel_grid):
    _, back = _affine(np.eye(2), np.zeros(2))
    case = make_case(back)
    foreign = wave_pattern(5.0, seed=99)(pixel_grid(SHAPE)).astype("f4")
    found = Case(case.reference, foreign, case.mask, case.other).match()
    claimed = (found.status == PointStatus.OK) & (found.zncc > 0.7)
    assert not claimed.any()
    assert found.iterations.max() <= 40


def test_too_few_iterations_are_told(make_case):
    _, back = _affine(GRADIENT, np.array([1.5, 1.0]))
    found = make_case(back).match(max_iterations=2)
    assert (found.status == PointStatus.NOT_CONVERGED).all()


def test_a_plain_step_too_far_is_taken_back(make_case):
    # a coarse pattern seen from half a speckle away: undamped steps overshoot
    shift = np.array([3.4, -2.4])
    _, back = _affine(np.eye(2), shift)
    found = make_case(back, size=9.0).match(max_drift=12.0)
    assert (found.status == PointStatus.OK).all()
    assert_allclose(found.position, POINTS + shift, atol=5e-3)
