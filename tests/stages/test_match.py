import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.spatial import cKDTree

from shapemorph.config import MatchConfig
from shapemorph.core.errors import StageError
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import UnmatchedError
from shapemorph.methods.synthetic.planar import (
    Exposure,
    inverse_at,
    planar_speckle,
    take_picture,
)
from shapemorph.methods.synthetic.planar_textures import cloudy, printed_dots, wood
from shapemorph.methods.warping import warp_points
from shapemorph.stages.match import match

CENTRE = np.array([170.0, 150.0])
BEFORE = Exposure(gain=1.0, offset=0.0, slope=0.0, noise=2.0, seed=1)
AFTER = Exposure(gain=0.8, offset=0.03, slope=0.2, noise=2.0, seed=2)


def disc_with_hole(points):
    inside = np.linalg.norm(points - CENTRE, axis=-1) < 145
    return inside & (np.linalg.norm(points - CENTRE - [50, -40], axis=-1) > 25)


def turned(degrees, scale=1.0, centre=(190.0, 200.0)):
    angle = np.deg2rad(degrees)
    matrix = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return stretched(matrix, centre)


def stretched(matrix, centre):
    back = np.linalg.inv(matrix)
    return lambda points: (points - centre) @ back.T + CENTRE


def bulged(points):
    """Stretch 2 at the centre, falling off towards the rim."""
    offset = points - np.array([190.0, 200.0])
    square = (offset**2).sum(-1, keepdims=True) / 170.0**2
    return CENTRE + offset / (1 + np.exp(-2 * square))


def pictures(
    material_at,
    *,
    shape=(400, 390),
    diameter=5.0,
    inside=disc_with_hole,
    seed=0,
    pattern=None,
):
    speckle = pattern or planar_speckle(diameter=diameter, seed=seed)
    before = take_picture(speckle, (300, 340), BEFORE, material_at=lambda p: p, inside=inside)
    after = take_picture(speckle, shape, AFTER, material_at=material_at, inside=inside)
    return before, after


def judge(matches, material_at, before, after):
    """Errors in px of pairs and of the warp at all points that both pictures show, and gaps."""
    rows, cols = np.nonzero(before.mask[::4, ::4])
    points = 4.0 * np.column_stack([cols, rows])
    claimed = warp_points(matches.forward, points)[0]
    true = inverse_at(material_at, points, claimed)
    height, width = after.shape
    seen = ((true > 0) & (true < [width - 1, height - 1])).all(axis=1)
    pair_truth = inverse_at(material_at, matches.reference_px, matches.deformed_px)
    pair_errors = np.linalg.norm(pair_truth - matches.deformed_px, axis=1)
    back = warp_points(matches.backward, true[seen])[0]
    gap = cKDTree(matches.reference_px[pair_errors < 2]).query(points[seen])[0].max()
    return {
        "pairs": pair_errors,
        "forward": np.linalg.norm(claimed - true, axis=1)[seen],
        "backward": np.linalg.norm(back - points[seen], axis=1),
        "gap": gap,
    }


CASES = {
    "half_turn": (turned(163.0, 1.1), {}),
    "smaller": (turned(-71.0, 0.6), {"diameter": 8.0}),
    "bulge": (bulged, {}),
    "coarse_bulge": (bulged, {"diameter": 11.0}),
    "fine": (turned(20.0), {"diameter": 2.5}),
    "uniaxial_2": (stretched(np.diag([2.0, 0.7]), (330.0, 110.0)), {"shape": (220, 650)}),
}


@pytest.mark.parametrize("name", CASES)
def test_pairs_are_right_and_warp_reaches_the_rim(name):
    material_at, options = CASES[name]
    before, after = pictures(material_at, **options)
    matches = match(before, after, MatchConfig())
    errors = judge(matches, material_at, before, after)
    coarse = options.get("diameter", 5.0) / 5.0
    assert (errors["pairs"] < 2).mean() >= 0.995
    assert np.median(errors["forward"]) < 0.1 * max(1, coarse)
    # a window of some four speckles cannot follow a curvature as narrow as itself
    assert errors["forward"].max() < 0.5 * max(1, coarse**2)
    assert errors["backward"].max() < 0.5 * max(1, coarse**2)
    assert errors["gap"] < 20 * max(1, coarse)  # no cell of 60 px is empty
    assert matches.fold_share == 0
    # the tool's own residual is of the order of the true error
    assert matches.residual_px < 3 * np.median(errors["pairs"]) + 0.02
    counts = matches.counts
    assert counts["matched"] >= counts["voted"] >= counts["consistent"] > 50
    assert counts["kept"] == len(matches.reference_px)


@pytest.mark.slow
def test_uniaxial_stretch_of_three():
    turn = np.array([[0.94, -0.34], [0.34, 0.94]])
    material_at = stretched(turn @ np.diag([3.0, 0.58]), (500.0, 260.0))
    before, after = pictures(material_at, shape=(520, 1000))
    errors = judge(match(before, after, MatchConfig()), material_at, before, after)
    assert (errors["pairs"] < 2).mean() >= 0.995
    assert errors["forward"].max() < 1.0
    assert errors["gap"] < 20


def test_kink_costs_no_region():
    def kinked(points):
        """Stretch 1.6 inside a circle, 1 outside."""
        offset = points - np.array([190.0, 200.0])
        radius = np.linalg.norm(offset, axis=-1, keepdims=True) + 1e-9
        inner = np.minimum(radius, 112.0) / 1.6
        return CENTRE + offset / radius * (inner + np.maximum(radius - 112.0, 0))

    before, after = pictures(kinked)
    errors = judge(match(before, after, MatchConfig()), kinked, before, after)
    assert (errors["pairs"] < 2).all()
    assert np.median(errors["forward"]) < 0.2
    assert errors["forward"].max() < 2.0
    assert errors["gap"] < 20


def test_part_out_of_sight_is_not_matched():
    material_at = turned(30.0, centre=(60.0, 90.0))
    before, after = pictures(material_at, shape=(260, 200))
    matches = match(before, after, MatchConfig())
    place = np.rint(matches.deformed_px).astype(int)
    assert after.mask[place[:, 1], place[:, 0]].all()
    errors = judge(matches, material_at, before, after)
    assert (errors["pairs"] < 2).all()


def test_same_pictures_give_the_same_bits_whatever_the_threads():
    import cv2
    import numba

    before, after = pictures(bulged)
    many = match(before, after, MatchConfig())
    threads = cv2.getNumThreads(), numba.get_num_threads()
    cv2.setNumThreads(1)
    numba.set_num_threads(1)
    try:
        one = match(before, after, MatchConfig())
    finally:
        cv2.setNumThreads(threads[0])
        numba.set_num_threads(threads[1])
    assert_array_equal(one.reference_px, many.reference_px)
    assert_array_equal(one.deformed_px, many.deformed_px)
    assert_array_equal(one.forward.coefficients, many.forward.coefficients)
    assert_array_equal(one.backward.coefficients, many.backward.coefficients)


def test_what_is_outside_the_masks_does_not_matter():
    before, after = pictures(bulged)
    clean = match(before, after, MatchConfig())
    noise = np.random.default_rng(0).random(after.shape).astype(np.float32)
    noisy = GreyImage(np.where(after.mask, after.grey, noise), after.mask)
    assert_array_equal(match(before, noisy, MatchConfig()).deformed_px, clean.deformed_px)


def mirrored(points):
    return points * [-1.0, 1.0] + [340.0, 0.0]


@pytest.mark.parametrize("seed", [0, 1])
def test_mirrored_pictures_are_refused_and_said_to_be_mirrored(seed):
    before, after = pictures(mirrored, seed=seed)
    says = r"one is mirrored: flip one of them; .* inside out, .*\(.*matched \d+, voted \d+"
    with pytest.raises(UnmatchedError, match=says):
        match(before, after, MatchConfig())


def test_negative_is_refused_and_said_to_be_one():
    before, after = pictures(bulged)
    inverted = GreyImage(np.where(after.mask, 1 - after.grey, 0), after.mask)
    with pytest.raises(UnmatchedError, match="contrast of one is inverted") as refusal:
        match(before, inverted, MatchConfig())
    assert refusal.value.reference_px.shape == refusal.value.deformed_px.shape
    assert refusal.value.reference_px.shape[1] == 2


def test_unrelated_pictures_are_refused_with_counts():
    before, _after = pictures(bulged)
    _other, unrelated = pictures(bulged, seed=100)
    with pytest.raises(UnmatchedError, match="0 pairs agree, 20 are needed"):
        match(before, unrelated, MatchConfig())


def test_equal_dots_are_refused_as_repeating():
    dots = printed_dots(pitch=16, other=None, share=0.0)
    before, after = pictures(bulged, pattern=dots)
    with pytest.raises(UnmatchedError, match=r"the pattern repeats every \d+ px"):
        match(before, after, MatchConfig())


def test_dots_on_a_faint_pattern_are_matched_rightly_and_with_doubt():
    dots = printed_dots(pitch=16, other=cloudy(width=4, seed=1), share=0.3)
    material_at = turned(20.0)
    before, after = pictures(material_at, pattern=dots)
    matches = match(before, after, MatchConfig())
    assert "repeats every" in matches.doubt
    errors = judge(matches, material_at, before, after)
    assert (errors["pairs"] < 2).all()


def whole(points):
    return ((points >= 0) & (points <= [339, 299])).all(axis=-1)


def test_clouds_that_are_drawn_far_are_held_by_their_fine_detail():
    drawn = stretched(np.diag([2.5, 2.5**-0.5]), (430.0, 120.0))
    clouds = cloudy(width=4, seed=2)
    before, after = pictures(drawn, shape=(240, 862), inside=whole, pattern=clouds)
    matches = match(before, after, MatchConfig())
    assert matches.manner.endswith("then fine detail")
    assert matches.doubt == ""
    assert judge(matches, drawn, before, after)["pairs"].max() < 1.0  # coarse clouds: 3 px


def test_long_grain_is_matched_with_doubt():
    drawn = stretched(np.diag([2.5, 2.5**-0.5]), (430.0, 120.0))
    grain = wood(width=4, seed=1)
    before, after = pictures(drawn, shape=(240, 862), inside=whole, pattern=grain)
    matches = match(before, after, MatchConfig())
    assert "holds some pairs only to" in matches.doubt
    errors = judge(matches, drawn, before, after)["pairs"]
    assert np.percentile(errors, 95) > 1.0  # px: the doubt is right


def test_random_speckle_leaves_no_doubt():
    before, after = pictures(bulged)
    assert match(before, after, MatchConfig()).doubt == ""


@pytest.mark.parametrize("kind", ["grey", "masked", "tiny", "noise"])
def test_pictures_without_a_pattern_are_refused(kind):
    before, _after = pictures(bulged)
    shape = (4, 5) if kind == "tiny" else (200, 180)
    grey = np.full(shape, 0.5, np.float32)
    if kind == "noise":
        grey = np.random.default_rng(0).normal(0.5, 0.02, shape).astype(np.float32)
    nothing = GreyImage(grey, np.full(shape, kind != "masked"))
    with pytest.raises(StageError) as first:
        match(before, nothing, MatchConfig())
    with pytest.raises(StageError) as second:
        match(nothing, before, MatchConfig())
    assert "\n" not in str(first.value)
    if kind != "noise":
        assert "the deformed picture is blank" in str(first.value)
        assert "the reference picture is blank" in str(second.value)


def test_too_few_pairs_say_how_many_and_what_to_change():
    before, after = pictures(bulged)
    with pytest.raises(StageError, match=r"5000 are needed.*voted.*match.ratio"):
        match(before, after, MatchConfig(min_matches=5000))
