import numpy as np
from numpy.testing import assert_allclose

from shapemorph.core.matching import Warp
from shapemorph.methods.first_pairs import first_pairs, measure_side
from shapemorph.methods.pairs_through import pairs_through
from shapemorph.methods.simulated_views import simulated_pairs
from shapemorph.methods.synthetic.planar import Exposure, planar_speckle, take_picture
from shapemorph.methods.synthetic.planar_textures import cloudy, printed_dots

TURN = np.deg2rad(40.0)
ROTATION = np.array([[np.cos(TURN), -np.sin(TURN)], [np.sin(TURN), np.cos(TURN)]])
MATRIX = ROTATION @ np.diag([2.4, 2.4**-0.5])  # reference to deformed, 3.7 : 1
SHAPE = (520, 620)


def pictures(pattern, seed=0):
    inside = lambda p: np.linalg.norm(p - 140, axis=-1) < 135  # noqa: E731
    centre, back = np.array(SHAPE[::-1]) / 2, np.linalg.inv(MATRIX)
    flat = Exposure(gain=1.0, offset=0.0, slope=0.0, noise=2.0, seed=seed)
    lit = Exposure(gain=0.85, offset=0.0, slope=0.2, noise=2.0, seed=seed + 1)
    before = take_picture(pattern, (280, 280), flat, material_at=lambda p: p, inside=inside)
    after = take_picture(
        pattern, SHAPE, lit, material_at=lambda p: (p - centre) @ back.T + 140, inside=inside
    )
    return before, after


def errors(pairs):
    true = (pairs.source - 140) @ MATRIX.T + np.array(SHAPE[::-1]) / 2
    return np.linalg.norm(pairs.target - true, axis=1)


def test_views_find_pairs_whose_stretch_the_speckle_does_not_show():
    pattern = printed_dots(pitch=16, other=cloudy(width=4, seed=5), share=0.4)
    before, after = pictures(pattern)
    left, right = measure_side(before, "one"), measure_side(after, "other")
    usual = first_pairs(left, right, ratio=0.85)
    _, pairs = simulated_pairs(left, right, ratio=0.85)
    assert len(pairs) > 1.5 * len(usual)
    assert len(pairs) > 40
    assert (errors(pairs) < 3).mean() > 0.97


def test_views_of_another_material_give_no_pairs():
    before, _ = pictures(planar_speckle(diameter=9.0, seed=1))
    _, after = pictures(planar_speckle(diameter=9.0, seed=2))
    _, pairs = simulated_pairs(
        measure_side(before, "one"), measure_side(after, "other"), ratio=0.85
    )
    assert len(pairs) == 0


def test_rough_warp_that_is_turned_wrongly_still_shows_the_same():
    """A law of revolution leaves the turn open: only the stretch has to be taken away."""
    before, after = pictures(planar_speckle(diameter=5.0, seed=1))
    # MATRIX = ROTATION @ stretch; the rough one compresses alike, but is turned by 40 degrees.
    rough, back_turned = np.diag([2.2, 2.4**-0.5]), ROTATION.T
    knots = np.stack(np.meshgrid(np.arange(-2, 9), np.arange(-2, 9)), -1) * 40.0
    targets = (knots - 140) @ (ROTATION @ rough @ back_turned).T + np.array(SHAPE[::-1]) / 2
    warp = Warp(targets, np.array([-80.0, -80.0]), 40.0)
    left, right = measure_side(before, "one"), measure_side(after, "other")
    (_, theirs), pairs = pairs_through(left, right, warp, ratio=0.85, known=None, reach=0.0)
    assert len(pairs) > 100
    assert (errors(pairs) < 3).mean() > 0.99
    near = pairs.source[:1]
    _, fewer = pairs_through(left, right, warp, ratio=0.85, known=near, reach=60.0)
    assert 0 < len(fewer) < len(pairs)
    assert_allclose(np.isfinite(theirs.frames), True)
