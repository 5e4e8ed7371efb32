import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from shapemorph.methods.contrast import Pattern, byte_picture
from shapemorph.methods.descriptor_match import match_descriptors
from shapemorph.methods.features import LENGTH, Features, detect_features
from shapemorph.methods.synthetic.planar import planar_speckle
from shapemorph.methods.views import View

TURN = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])


def view(matrix, shape=(220, 300)):
    """See one speckle through an affine map of the material."""
    rows, cols = np.mgrid[: shape[0], : shape[1]].astype(np.float64)
    seen = np.stack([cols, rows], -1) - matrix[:, 2]
    material = seen @ np.linalg.inv(matrix[:, :2]).T
    values = planar_speckle(diameter=6.0, seed=0).at(material).astype(np.float32)
    return View(byte_picture(values), np.ones(shape, bool), matrix)


STRAIGHT = view(np.array([[1.0, 0, 0], [0, 1.0, 0]]))
TURNED = view(np.column_stack([1.2 * TURN, [120.0, -40.0]]))


def features(*views, per_cell=6):
    return detect_features(views, contrast=0.02, cell=40.0, per_cell=per_cell)


def test_features_of_a_turned_view_come_back_to_the_same_places_with_the_same_frames():
    first, second = features(STRAIGHT), features(TURNED)
    i, j = match_descriptors(first, second, ratio=0.8, apart=3.0)
    distance = np.linalg.norm(first.points[i] - second.points[j], axis=1)
    right = distance < 1.5
    assert len(i) > 50
    assert right.mean() > 0.95
    # both views show one picture: no shift may be left between their features
    assert_allclose((first.points[i] - second.points[j])[right].mean(axis=0), 0, atol=0.05)
    between = second.frames[j[right]] @ np.linalg.inv(first.frames[i[right]])
    assert_allclose(np.median(between, axis=0), np.eye(2), atol=0.05)


def test_strongest_of_every_cell_are_kept():
    places = np.floor(features(STRAIGHT, per_cell=3).points / 40).astype(int)
    _cells, counts = np.unique(places, axis=0, return_counts=True)
    assert counts.max() <= 4  # cells are counted from the first feature's own cell
    assert len(counts) > 30


def test_no_feature_outside_the_mask():
    mask = np.zeros(STRAIGHT.mask.shape, bool)
    mask[:, 100:200] = True
    points = features(View(STRAIGHT.grey, mask, STRAIGHT.matrix)).points
    assert len(points) > 20
    assert points[:, 0].min() > 100
    assert points[:, 0].max() < 200


def test_blank_view_has_no_features():
    blank = View(np.full((80, 90), 128, np.uint8), np.ones((80, 90), bool), STRAIGHT.matrix)
    assert len(features(blank)) == 0
    assert len(features()) == 0


def test_descriptors_are_whole_numbers_whose_products_are_exact():
    descriptors = features(STRAIGHT).descriptors
    assert_array_equal(descriptors, np.rint(descriptors))
    lengths = np.linalg.norm(descriptors.astype(np.float64), axis=1)
    assert_allclose(lengths, LENGTH, rtol=1e-2)
    assert lengths.max() ** 2 < 2**24  # below it 32-bit floats count exactly
    exact = descriptors.astype(np.int64) @ descriptors.T.astype(np.int64)
    assert_array_equal(descriptors @ descriptors.T, exact)


def made_up(points, descriptors):
    frames = np.tile(np.eye(2), (len(points), 1, 1))
    return Features(np.array(points, float), np.array(descriptors, np.float32), frames)


def code(*places):
    """A descriptor with weight at given places."""
    descriptor = np.zeros(128)
    for place, weight in places:
        descriptor[place] = weight
    return np.rint(4000 * descriptor / np.linalg.norm(descriptor))


def test_pairs_are_mutual_and_clear():
    reference = made_up(
        [[0, 0], [9, 0], [0, 9]], [code((0, 1)), code((0, 1), (1, 0.2)), code((5, 1))]
    )
    deformed = made_up(
        [[1, 1], [50, 50], [90, 90]],
        [code((0, 1), (1, 0.05)), code((5, 1)), code((5, 1), (6, 0.05))],
    )
    i, j = match_descriptors(reference, deformed, ratio=0.85, apart=3.0)
    # 1 prefers deformed 0, which prefers 0; 2 has an exact match, and a near twin elsewhere
    assert list(zip(i, j, strict=True)) == [(0, 0), (2, 1)]


def test_twins_at_one_place_do_not_compete_but_twins_elsewhere_do():
    twins = [code((0, 1), (1, 0.1)), code((0, 1), (1, 0.11)), code((7, 1))]
    reference = made_up([[0, 0]], [code((0, 1))])
    near = made_up([[10, 10], [11, 10], [40, 40]], twins)
    far = made_up([[10, 10], [30, 10], [40, 40]], twins)
    assert len(match_descriptors(reference, near, ratio=0.85, apart=3.0)[0]) == 1
    assert len(match_descriptors(reference, far, ratio=0.85, apart=3.0)[0]) == 0


def test_nothing_to_match_is_no_pair():
    nothing = made_up(np.empty((0, 2)), np.empty((0, 128)))
    something = made_up([[0, 0], [5, 5]], [code((0, 1)), code((1, 1))])
    for left, right in ((nothing, something), (something, nothing)):
        assert len(match_descriptors(left, right, ratio=0.85, apart=3.0)[0]) == 0


def test_pattern_of_a_view_is_that_of_the_picture():
    # the helper above against the contrast module: one grey scale for both
    assert Pattern(np.zeros((2, 3), np.float32), np.ones((2, 3), bool), 0.1).shape == (2, 3)
    assert byte_picture(np.zeros((1, 1), np.float32))[0, 0] == 128
