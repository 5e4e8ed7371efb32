import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.core.laws import Dots
from shapemorph.methods.contrast import Pattern, byte_picture
from shapemorph.methods.descriptor_match import match_descriptors
from shapemorph.methods.features import detect_features
from shapemorph.methods.first_pairs import equally_soft, first_pairs, measure_fine_side
from shapemorph.methods.second_tries import find_start, mirrored, negative
from shapemorph.methods.speckle_ellipse import measure_speckle, without_blur
from shapemorph.methods.synthetic.planar import Exposure, inverse_at, planar_speckle, take_picture
from shapemorph.methods.synthetic.planar_textures import wood
from shapemorph.methods.views import View

PLAIN = Exposure(gain=1.0, offset=0.0, slope=0.0, noise=2.0, seed=1)


def features_of(grey):
    matrix = np.array([[1.0, 0, 0], [0, 1.0, 0]])
    view = View(np.ascontiguousarray(grey), np.ones(grey.shape, bool), matrix)
    return detect_features([view], contrast=0.02, cell=40.0, per_cell=6)


def speckle_bytes():
    rows, cols = np.mgrid[:220, :300].astype(np.float64)
    speckle = planar_speckle(diameter=6.0, seed=0)
    return byte_picture(speckle.at(np.stack([cols, rows], -1)).astype(np.float32))


def drawn(stretch, shape, middle=150.0):
    """Picture in which the material is drawn along x about its middle."""
    centre = np.array(shape[::-1]) / 2
    return lambda points: (points - centre) * [1 / stretch, stretch**0.5] + middle


def pictures(pattern, stretch, shape, **after):
    inside = lambda p: np.linalg.norm(p - 150, axis=-1) < 145  # noqa: E731
    exposure = Exposure(gain=0.9, offset=0.0, slope=0.1, noise=2.0, seed=2, **after)
    material_at = drawn(stretch, shape)
    before = take_picture(pattern, (300, 300), PLAIN, material_at=lambda p: p, inside=inside)
    return (
        before,
        take_picture(pattern, shape, exposure, material_at=material_at, inside=inside),
        material_at,
    )


def test_negative_features_are_those_of_the_negative():
    grey = speckle_bytes()
    claimed, true = negative(features_of(grey)), features_of(255 - grey)
    i, j = match_descriptors(claimed, true, ratio=0.8, apart=3.0)
    assert len(i) > 0.8 * len(true)
    assert_allclose(claimed.points[i], true.points[j], atol=1.0)
    between = true.frames[j] @ np.linalg.inv(claimed.frames[i])
    assert_allclose(np.median(between, axis=0), np.eye(2), atol=0.02)


def test_mirrored_features_are_those_of_the_mirror_image():
    grey = speckle_bytes()
    claimed, true = mirrored(features_of(grey)), features_of(grey[:, ::-1])
    i, j = match_descriptors(claimed, true, ratio=0.8, apart=3.0)
    assert len(i) > 0.5 * len(true)
    shift = true.points[j] - claimed.points[i]
    assert_allclose(np.median(shift, axis=0), [299.0, 0.0], atol=0.1)
    between = true.frames[j] @ np.linalg.inv(claimed.frames[i])
    assert_allclose(np.median(between, axis=0), np.eye(2), atol=0.02)


def test_blur_that_is_known_is_taken_off_the_speckle():
    noise = np.random.default_rng(0).normal(size=(500, 600)).astype(np.float32)
    sharp, soft = (
        cv2.GaussianBlur(noise, (0, 0), np.sqrt(var)) for var in (2.5**2, 2.5**2 + 1.5**2)
    )
    fields = [
        measure_speckle(Pattern(v / v.std(), np.ones(v.shape, bool), 0.2), window=200)
        for v in (sharp, soft)
    ]
    assert_allclose(without_blur(fields[1], 1.5).std, fields[0].std, rtol=0.03)


@pytest.mark.slow
def test_deformed_picture_out_of_focus_is_matched():
    before, after, material_at = pictures(
        planar_speckle(diameter=4.5, seed=3), 3.0, (190, 920), blur=2.0
    )
    start = find_start(before, after, ratio=0.85, enough=20)
    assert "deformed picture out of focus" in start.manner
    pairs = start.pairs
    assert len(pairs) >= 20
    true = inverse_at(material_at, pairs.source, pairs.target)
    assert (np.linalg.norm(true - pairs.target, axis=1) < 6).mean() > 0.95
    sharp, soft = equally_soft(start.right, 2.0)
    assert sharp.wanted == soft.wanted
    assert (sharp.lens, soft.lens) == (0.0, 2.0)


@pytest.mark.slow
def test_fine_detail_of_long_grain_follows_the_stretch():
    before, after, material_at = pictures(wood(width=4.0, seed=1), 2.0, (230, 620))
    left, right = (measure_fine_side(image, "") for image in (before, after))
    stretch = np.diag([2.0, 2.0**-0.5])
    values, axes = np.linalg.eigh(left.speckle.median)
    expected = stretch @ (axes * np.exp(values)) @ axes.T @ stretch.T
    values, axes = np.linalg.eigh(right.speckle.median)
    found = (axes * np.exp(values)) @ axes.T
    ratio = np.linalg.eigvals(np.linalg.solve(expected, found)).real
    assert_allclose(ratio / np.sqrt(ratio.prod()), 1.0, rtol=0.35)
    pairs = first_pairs(left, right, ratio=0.85)
    true = inverse_at(material_at, pairs.source, pairs.target)
    assert len(pairs) >= 15
    assert (np.linalg.norm(true - pairs.target, axis=1) < 10).mean() > 0.9


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_features_found_before_are_taken_if_they_leave_no_large_gap(share):
    stretch, shape = 1.2, (330, 400)
    before, after, material_at = pictures(planar_speckle(diameter=6.0, seed=3), stretch, shape)
    grid = np.stack(np.meshgrid(np.arange(20, 290, 14.0), np.arange(20, 290, 14.0)), -1)
    source = grid.reshape(-1, 2)
    source = source[np.linalg.norm(source - 150, axis=1) < 140]
    source = source[source[:, 0] <= 300 * share]
    target = inverse_at(material_at, source, np.array(shape[::-1]) / 2)
    start = find_start(before, after, ratio=0.8, enough=40, found=Dots(source, target))
    assert ("features_before" in start.pairs.counts) == (share == 1.0)
    assert_allclose(material_at(start.pairs.target), start.pairs.source, atol=2.0)
