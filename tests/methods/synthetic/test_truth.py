"""The truth: exact in the frames of the files, even where it is asked for between vertices."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import LinearNDInterpolator

from shapemorph.core.synthetic import DamageSpot
from shapemorph.methods.synthetic.shapes import material_map
from shapemorph.methods.synthetic.sides import random_pose
from shapemorph.methods.synthetic.truth import (
    make_truth,
    random_material,
    true_tensor,
    truth_at,
    truth_of_material,
)

SHAPES = ("dome", "bulge", "indentation", "freeform", "hole", "tube", "rigid")
SPOT = DamageSpot("lost_patch", np.array([4.0, 12.0]), 3.0)


def _truth(shape, size=70.0, seed=0):
    rng = np.random.default_rng(seed)
    poses = (random_pose(size, rng), random_pose(size, rng))
    offset, tilt = (5.0, -0.1) if shape == "indentation" else (0.0, 0.0)
    return make_truth(shape, size=size, offset=offset, tilt=tilt, poses=poses, damage=(SPOT,))


@pytest.mark.parametrize("shape", SHAPES)
def test_points_of_the_reference_file_find_their_material(shape):
    truth = _truth(shape)
    material = random_material(truth, 500, inset=1.0, seed=1)
    exact = truth_of_material(truth, material)
    found = truth_at(truth, exact.reference)
    for name in ("reference", "deformed", "e1", "e2", "rim_distance", "kink_distance"):
        assert_allclose(getattr(found, name), getattr(exact, name), atol=1e-6, err_msg=name)
    assert np.array_equal(found.visible, exact.visible)
    assert not exact.visible.all()


def test_positions_are_those_of_the_map_carried_by_the_poses():
    truth = _truth("indentation")
    mapped = material_map("indentation", size=70.0, offset=5.0, tilt=-0.1)
    material = random_material(truth, 50, inset=0.0, seed=2)
    exact = truth_of_material(truth, material)
    back = truth.deformed_pose.inverse().apply(exact.deformed)
    assert_allclose(back, mapped.deformed(material)[0], atol=1e-10)
    assert not np.allclose(truth.reference_pose.rotation, truth.deformed_pose.rotation)


@pytest.mark.parametrize("shape", ["dome", "freeform", "tube"])
def test_the_true_tensor_has_the_true_principal_values_in_any_basis(shape):
    truth = _truth(shape)
    exact = truth_of_material(truth, random_material(truth, 40, inset=1.0, seed=4))
    step = 1e-4
    near = [
        truth_of_material(truth, exact.material + step * np.eye(2)[k]).reference for k in range(2)
    ]
    edges = np.stack([(point - exact.reference) / step for point in near], axis=1)
    basis = np.swapaxes(np.linalg.qr(np.swapaxes(edges, 1, 2))[0], 1, 2)
    tensor = true_tensor(truth, exact.reference, basis)
    values = np.linalg.eigvalsh(tensor)
    assert_allclose(values, np.stack([exact.e2, exact.e1], axis=1), atol=1e-4)
    turn = np.array([[0.6, 0.8], [-0.8, 0.6]])
    turned = true_tensor(truth, exact.reference, turn @ basis)
    assert_allclose(turned, turn @ tensor @ turn.T, atol=1e-10)


@pytest.mark.parametrize("shape", ["rigid", "hole", "freeform"])
def test_random_material_is_even_in_area_and_off_the_rim(shape):
    truth = _truth(shape)
    material = random_material(truth, 20_000, inset=1.5, seed=3)
    exact = truth_of_material(truth, material)
    assert len(material) == 20_000
    assert exact.rim_distance.min() >= 1.5
    # A ball of fixed radius in space holds an equal share of points wherever it sits.
    pose = truth.reference_pose.inverse()
    body = pose.apply(exact.reference)
    counts = [
        np.sum(np.linalg.norm(body - body[np.argmin(np.abs(material - m).sum(1))], axis=1) < 5)
        for m in (np.array([14.0, 8.0]), np.array([-16.0, 4.0]), np.array([9.0, -13.0]))
    ]
    assert np.ptp(counts) < 6 * np.sqrt(np.mean(counts))


def test_the_table_says_the_same_for_those_who_interpolate():
    truth = _truth("dome")
    exact = truth_of_material(truth, random_material(truth, 300, inset=3.0, seed=4))
    table = truth.table
    found = LinearNDInterpolator(table.material, table.e2)(exact.material)
    assert np.abs(found - exact.e2).max() < 0.01  # 0.9 mm grid
    position = LinearNDInterpolator(table.material, table.deformed)(exact.material)
    assert np.linalg.norm(position - exact.deformed, axis=1).max() < 0.1


def test_the_same_call_draws_the_same_points():
    truth = _truth("hole")
    one, again = (random_material(truth, 100, inset=1.0, seed=7) for _ in range(2))
    assert np.array_equal(one, again)
    assert not np.array_equal(one, random_material(truth, 100, inset=1.0, seed=8))
