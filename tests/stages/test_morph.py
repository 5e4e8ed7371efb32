"""The deformed picture brought close to the reference."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial import Delaunay

from shapemorph.config import MorphConfig
from shapemorph.core.errors import ConfigError, StageError
from shapemorph.core.image import CalibratedImage, Chart, GreyImage
from shapemorph.core.landmarks import Landmarks
from shapemorph.core.laws import LawInputs, NodalField, RadialProfile
from shapemorph.core.matching import Matches, Warp
from shapemorph.core.mesh import coloured_mesh
from shapemorph.methods.laws.identity import identity_warp
from shapemorph.methods.warping import warp_points
from shapemorph.stages.morph import Side, law_warp, morph_pictures

SHAPE = (70, 110)
SLOPE = np.array([[0.0, 1.2], [-0.9, 0.1]])  # a quarter turn and some stretch
SHIFT = np.array([8.0, 105.0])


def _matches():
    spacing, origin = 30.0, np.array([-60.0, -60.0])
    cols, rows = np.meshgrid(np.arange(9.0), np.arange(8.0))
    knots = origin + spacing * np.stack([cols, rows], axis=-1)
    warp = Warp(knots @ SLOPE.T + SHIFT, origin, spacing)
    nothing = np.zeros((0, 2))
    return Matches(nothing, nothing, warp, warp, {}, 0.0, 0.0, 0.0)


def test_the_morphed_picture_looks_like_the_reference(wave_pattern, pixel_grid):
    pattern, big = wave_pattern(7.0), (120, 130)
    material = (pixel_grid(big) - SHIFT) @ np.linalg.inv(SLOPE).T
    deformed = GreyImage(pattern(material).astype("f4"), np.ones(big, dtype=bool))
    reference = GreyImage(np.zeros(SHAPE, "f4"), np.ones(SHAPE, dtype=bool))
    found = morph_pictures(reference, deformed, _matches(), LawInputs(), MorphConfig())
    assert found.image.shape == SHAPE
    inner = found.image.mask.copy()
    inner[:6], inner[-6:], inner[:, :6], inner[:, -6:] = False, False, False, False
    assert inner.mean() > 0.6
    expected = pattern(pixel_grid(SHAPE))
    assert_allclose(found.image.grey[inner], expected[inner], atol=0.03)
    assert found.warp is not None
    assert found.overruled == 0


def test_identity_leaves_the_picture_alone(wave_pattern, pixel_grid):
    picture = GreyImage(wave_pattern()(pixel_grid(SHAPE)).astype("f4"), np.ones(SHAPE, dtype=bool))
    none = replace(_matches(), forward=None, backward=None)
    config = MorphConfig(law="identity")
    found = morph_pictures(picture, picture, none, LawInputs(), config)
    # the pictures agree with the law to a few hundredths of a pixel, and so does what is kept
    assert_allclose(found.image.grey[3:-3, 3:-3], picture.grey[3:-3, 3:-3], atol=0.02)


@pytest.mark.parametrize("shape", [(5, 5), (40, 900)])
def test_the_identity_warp_holds_beyond_the_picture(shape):
    points = np.array([[-5.0, -3.0], [shape[1] + 9.0, shape[0] + 4.0], [1.5, 2.25]])
    targets, gradient = warp_points(identity_warp(shape), points)
    assert_allclose(targets, points, atol=1e-9)
    assert_allclose(gradient, np.broadcast_to(np.eye(2), (3, 2, 2)), atol=1e-12)


def _surface(calibrated, place):
    """Textured sheet over its own picture; `place` carries px to space."""
    chart = calibrated.chart
    vertices = place(chart.vertex_px)
    grey = np.full((len(chart.faces), 3), 0.5)
    return coloured_mesh(vertices, chart.faces, grey, name="sheet")


def _calibrated(shape, step=10.0, pages=1):
    columns, rows = np.meshgrid(
        np.arange(-1, shape[1] + step, step), np.arange(-1, shape[0] + step, step)
    )
    flat = np.stack([columns, rows], axis=-1).reshape(-1, 2)
    faces = Delaunay(flat).simplices.astype(np.int64)
    edges = flat[faces[:, 1:]] - flat[faces[:, :1]]
    flipped = np.linalg.det(edges) > 0
    faces[flipped] = faces[flipped][:, ::-1]
    starts = np.arange(pages) * 20
    chart = Chart(np.arange(len(flat)), faces, np.arange(len(faces)), flat, 2.0, starts)
    blank = GreyImage(np.zeros(shape, "f4"), np.ones(shape, dtype=bool))
    nowhere = np.full(shape, -1, np.int32), np.full((*shape, 2), np.nan)
    return CalibratedImage(blank, chart, *nowhere)


def _flat(px):
    return np.column_stack([px / 2.0, np.zeros(len(px))])


def _bowl(px):
    """The same sheet, twice as large in its picture, bent to a paraboloid."""
    plane = (px - np.array([120.0, 80.0])) / 4.0
    return np.column_stack([plane, 0.01 * (plane**2).sum(axis=1)])


def _sides(pages=1):
    reference, deformed = _calibrated(SHAPE, pages=pages), _calibrated((160, 240))
    left, right = _surface(reference, _flat), _surface(deformed, _bowl)
    return (
        Side(reference.image, left, reference),
        Side(deformed.image, right, deformed),
    )


def _truth(px):
    """The picture of the reference, twice as large about another centre."""
    return 2.0 * (px - np.array([55.0, 35.0])) + np.array([120.0, 80.0])


def _true_matches(count=80):
    source = np.random.default_rng(0).uniform([5, 5], [105, 65], (count, 2))
    return replace(_matches(), reference_px=source, deformed_px=_truth(source))


def _off(warp):
    points = np.random.default_rng(1).uniform([10, 10], [100, 60], (200, 2))
    return np.linalg.norm(warp_points(warp, points)[0] - _truth(points), axis=1).max()


def test_a_field_of_finite_elements_gives_the_way_through_space():
    nodes = np.random.default_rng(3).uniform([0, 0], [110, 70], (2000, 2))
    before, after = _flat(nodes), _bowl(_truth(nodes))
    inputs = LawInputs(finite_elements=NodalField(before, after - before))
    config = MorphConfig(law="fe", fe="model.vtu")
    # facets of 2.5 mm lie 0.02 mm below the paraboloid; 4 px are 1 mm
    assert _off(law_warp(*_sides(), _true_matches(), inputs, config, law="fe")) < 0.15


def test_a_profile_of_finite_elements_is_laid_over_the_matches():
    radius = np.linspace(0, 40, 60)
    inputs = LawInputs(finite_elements=RadialProfile(radius, radius, 0.01 * radius**2))
    config = MorphConfig(law="fe", fe="model.csv")
    assert _off(law_warp(*_sides(), _true_matches(), inputs, config, law="fe")) < 0.3


def test_landmarks_of_the_shapes_are_carried_into_the_pictures():
    marks = np.array([[10.0, 8], [100, 12], [95, 60], [15, 55], [60, 30]])
    landmarks = Landmarks(tuple("abcde"), _flat(marks), _bowl(_truth(marks)))
    config = MorphConfig(law="landmarks")
    inputs = LawInputs(landmarks=landmarks)
    assert _off(law_warp(*_sides(), _true_matches(), inputs, config, law="landmarks")) < 0.3


@pytest.mark.parametrize("given", [False, True])
def test_a_polynomial_is_fitted_to_the_matches_or_given_in_mm_of_the_pictures(given):
    coefficients = [0.5] if given else None
    config = MorphConfig(law="polynomial", coefficients=coefficients, centre=(55.0, 35.0))
    found = law_warp(*_sides(), _true_matches(), LawInputs(), config, law="polynomial")
    assert _off(found) < 0.05


def test_a_law_needs_what_it_is_made_of():
    sides, matches = _sides(), _true_matches()
    with pytest.raises(ConfigError, match=r"give morph\.dots or inputs\.landmarks"):
        law_warp(*sides, matches, LawInputs(), MorphConfig(law="landmarks"), law="landmarks")
    few = Landmarks(("a", "b"), np.zeros((2, 3)), np.zeros((2, 3)))
    with pytest.raises(ConfigError, match="at least 3 marks"):
        law_warp(
            *sides, matches, LawInputs(landmarks=few), MorphConfig(law="landmarks"), law="landmarks"
        )
    with pytest.raises(StageError, match="flat in one piece, got 3 pages"):
        law_warp(*_sides(pages=3), matches, LawInputs(), MorphConfig(), law="polynomial")
