import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shapemorph.core.errors import DataError
from shapemorph.methods.rigid import fit_rigid, fit_triples, refuse_mirrored, residuals_of

TURN = Rotation.from_rotvec([0.4, -0.7, 1.1]).as_matrix()
SHIFT = np.array([30.0, -12.0, 7.0])
POINTS = np.array([[0.0, 0, 0], [10, 1, 0], [2, 7, 1], [4, 3, 5], [-3, 2, 2]])


def test_motion_of_exact_pairs_is_found_to_rounding():
    found = fit_rigid(POINTS, POINTS @ TURN.T + SHIFT, np.ones(5))
    np.testing.assert_allclose(found.rotation, TURN, atol=1e-13)
    np.testing.assert_allclose(found.translation, SHIFT, atol=1e-12)


def test_three_points_are_enough_and_never_give_a_reflection():
    found = fit_rigid(POINTS[:3], POINTS[:3] @ TURN.T, np.ones(3))
    np.testing.assert_allclose(found.rotation, TURN, atol=1e-13)


def test_pair_without_weight_is_ignored():
    target = POINTS @ TURN.T + SHIFT
    target[4] += 50
    found = fit_rigid(POINTS, target, np.array([1.0, 1, 2, 1, 0]))
    np.testing.assert_allclose(found.rotation, TURN, atol=1e-12)


@pytest.mark.parametrize("count", [2, 5])
def test_points_on_a_line_are_refused_with_a_reason(count):
    line = np.arange(count)[:, None] * np.array([1.0, 2, 3])
    with pytest.raises(DataError, match="not on one line"):
        fit_rigid(line, line, np.ones(count))


def test_mirrored_set_is_refused_with_a_reason():
    mirrored = (POINTS * [1, 1, -1]) @ TURN.T + SHIFT
    with pytest.raises(DataError, match="mirrored"):
        refuse_mirrored(POINTS, mirrored)


def test_deformed_and_flat_sets_are_not_taken_for_mirrored():
    refuse_mirrored(POINTS, (POINTS * [2.0, 1.5, 0.8]) @ TURN.T)
    flat = POINTS * [1, 1, 0]
    refuse_mirrored(flat, flat @ TURN.T + SHIFT)


def test_many_fits_at_once_agree_with_single_ones():
    rng = np.random.default_rng(11)
    source = rng.normal(size=(20, 3, 3))
    target = source @ TURN.T + rng.normal(0, 0.1, source.shape)
    rotations, translations = fit_triples(source, target)
    for k in range(20):
        expected = fit_rigid(source[k], target[k], np.ones(3))
        np.testing.assert_allclose(rotations[k], expected.rotation, atol=1e-10)
        np.testing.assert_allclose(translations[k], expected.translation, atol=1e-10)


def test_residuals_are_distances_after_the_motion():
    motion = fit_rigid(POINTS, POINTS @ TURN.T, np.ones(5))
    target = POINTS @ TURN.T + [0, 3, 4]
    np.testing.assert_allclose(residuals_of(motion, POINTS, target), 5, atol=1e-12)
