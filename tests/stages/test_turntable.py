"""A sheet on a turntable: what its pictures show is what its truth says."""

import numpy as np
import pytest

from shapemorph.config import TwinConfig
from shapemorph.methods.cameras.dot_names import identify
from shapemorph.methods.cameras.dots import find_dots
from shapemorph.methods.synthetic.membrane.smooth import map_points
from shapemorph.stages.turntable import (
    dots_on_diameter,
    landmarks,
    make_turn_twin,
    marks,
    other_law,
    turn_pictures,
)

SMALL = TwinConfig(kind="bulge", scale=0.2, frames=2, rings=8, samples=1)


@pytest.fixture(scope="module")
def twin():
    return make_turn_twin(SMALL)


@pytest.fixture(scope="module")
def frames(twin):
    return [list(turn_pictures(twin, SMALL, state)) for state in (0, 1)]


def strain(twin, material):
    _, slope = map_points(twin.maps[1], material)
    return np.linalg.eigvalsh((np.swapaxes(slope, 1, 2) @ slope - np.eye(2)) / 2)


def test_the_pole_is_strained_most_and_alike_both_ways(twin):
    pole, low = strain(twin, np.array([[0.01, 0.0], [0.0, 15.0]]))
    assert pole.min() > 1.5
    assert pole[1] - pole[0] < 0.02
    assert low.max() < 0.8


def test_the_cone_is_seen_where_the_truth_says(twin, frames):
    for state in frames:
        for frame, pose in zip(state, twin.poses, strict=True):
            ids, pixels = identify(twin.target, find_dots(frame.grey, dark=True, least_px=5.5), [])
            assert len(ids) > 60
            expected = twin.camera.project(pose.apply(twin.target.points[ids]))
            off = np.linalg.norm(pixels - expected, axis=1)
            assert np.median(off) < 0.15  # the middle of a slanted dot is not that of its picture


def test_glare_comes_with_the_bulge_and_its_middle_is_dark(twin, frames):
    flat, bulged = (state[0] for state in frames)
    assert (flat.grey[flat.mask] > 0.97).mean() < 1e-4
    assert 0.002 < (bulged.grey[bulged.mask] > 0.97).mean() < 0.05
    poles = [marks(twin, np.array([[0.0, 0.0]]))[state] for state in (0, 1)]
    bright = []
    for frame, pole in zip((flat, bulged), poles, strict=True):
        x, y = np.rint(twin.camera.project(twin.poses[0].apply(pole)))[0].astype(int)
        bright.append(frame.grey[y - 4 : y + 5, x - 4 : x + 5].max())
    assert bright[1] < 0.7 * bright[0]


def test_a_turn_by_half_shows_the_other_side(frames):
    first, second = frames[1]
    both = first.mask & second.mask
    assert np.corrcoef(first.grey[both], second.grey[both])[0, 1] < 0.9
    assert np.abs(first.mask.mean() - second.mask.mean()) < 0.01


def test_marks_lie_on_the_sheet_and_hands_find_them_roughly(twin):
    before, after = landmarks(twin, SMALL)
    assert before.shape == after.shape == (3, 3)
    assert np.abs(np.linalg.norm(before[:, :2], axis=1) - 26.0).max() < 0.5
    diameter = dots_on_diameter(twin)
    flat, blown = marks(twin, diameter)
    assert np.ptp(flat[:, 2]) < 1e-6
    assert blown[:, 2].max() > 24.0


def test_the_law_is_of_other_conditions_and_goes_on_over_the_flange(twin):
    law = other_law(SMALL)
    assert law.material[-1] == pytest.approx(twin.edge)
    true, _ = map_points(twin.maps[1], np.column_stack([law.material[:6], np.zeros(6)]))
    assert np.abs(law.height[:6] - true[:, 2]).max() > 1.0


def test_the_closed_form_has_its_strain():
    analytic = make_turn_twin(SMALL.model_copy(update={"law": "analytic", "rings": 24}))
    found = strain(analytic, np.array([[6.0, 0.0], [0.0, 12.0]]))
    np.testing.assert_allclose(found[:, 1], 1.5, atol=0.02)
