"""Comparison with the truth: errors that are put in come out."""

import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.core.measurement import Measurement
from shapemorph.core.synthetic import DamageSpot
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.comparison import Yardstick, compare_with_truth
from shapemorph.methods.synthetic.sides import random_pose
from shapemorph.methods.synthetic.truth import make_truth, true_tensor, truth_of_material

YARDSTICK = Yardstick(
    wrong=0.25,
    wrong_fixed=0.25,
    kink_margin=1.5,
    rim_margin=1.5,
    reach=1.0,
    samples=4000,
    seed=0,
)


def _truth(shape="bulge", damage=()):
    poses = (
        random_pose(70.0, np.random.default_rng(0)),
        random_pose(70.0, np.random.default_rng(1)),
    )
    return make_truth(shape, size=70.0, offset=0.0, tilt=0.0, poses=poses, damage=damage)


def _perfect(truth, spacing=0.7):
    """A measurement on a grid of the disc without any error, aligned by the true poses."""
    axis = np.arange(-34.8, 34.8, spacing)
    material = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    material = material[np.linalg.norm(material, axis=1) < 34.9]
    exact = truth_of_material(truth, material)
    back = truth.deformed_pose.inverse().apply(exact.deformed)
    arrays = {
        "status": np.zeros(len(material), dtype=np.uint8),
        "deformed_position": exact.deformed.copy(),
        "displacement": truth.reference_pose.apply(back) - exact.reference,
        "E1": exact.e1.copy(),
        "E2": exact.e2.copy(),
    }
    cells = np.zeros((0, 4), dtype=np.int64)
    return Measurement(exact.reference, cells, arrays), exact


def test_a_perfect_measurement_has_no_errors_and_covers_all():
    truth = _truth()
    measurement, _ = _perfect(truth)
    found = compare_with_truth(measurement, truth, yardstick=YARDSTICK)
    assert found["ok_points"] == found["points"] == len(measurement.reference)
    assert found["wrong_points"] == 0
    assert found["error_mm"]["max"] < 1e-10
    assert found["dE1"]["max"] < 1e-10
    assert found["displacement_error_mm"]["max"] < 1e-10
    assert found["coverage"] == found["visible_coverage"] == 1.0


def test_a_known_error_is_found_point_by_point():
    truth = _truth()
    measurement, _ = _perfect(truth)
    count = len(measurement.reference)
    shift = np.full(count, 0.01)
    shift[: count // 10] = 0.02
    shift[:7] = 3.0
    measurement.arrays["deformed_position"] += shift[:, None] * np.array([0.6, 0.0, 0.8])
    found = compare_with_truth(measurement, truth, yardstick=YARDSTICK)
    assert found["error_mm"]["median"] == pytest.approx(0.01)
    assert found["error_mm"]["p95"] == pytest.approx(0.02)
    assert found["error_mm"]["max"] == pytest.approx(3.0)
    assert found["wrong_points"] == 7
    assert found["wrong_share"] == pytest.approx(7 / count)


def test_the_gauge_of_the_alignment_is_no_error_but_a_warp_is():
    truth = _truth()
    measurement, _ = _perfect(truth)
    turn = random_pose(1.0, np.random.default_rng(5))
    moved = measurement.reference + measurement.arrays["displacement"]
    measurement.arrays["displacement"] = turn.apply(moved) - measurement.reference
    found = compare_with_truth(measurement, truth, yardstick=YARDSTICK)
    assert found["displacement_error_mm"]["max"] < 1e-9
    measurement.arrays["displacement"] += 0.01 * measurement.reference
    found = compare_with_truth(measurement, truth, yardstick=YARDSTICK)
    assert found["displacement_error_mm"]["median"] > 0.02


def test_material_without_a_right_point_near_it_is_not_covered():
    truth = _truth()
    measurement, exact = _perfect(truth)
    lost = np.linalg.norm(exact.material - np.array([10.0, -5.0]), axis=1) < 9.0
    measurement.arrays["status"][lost] = 6
    measurement.arrays["deformed_position"][lost] = np.nan
    bare = np.linalg.norm(exact.material - np.array([-14.0, 5.0]), axis=1) < 6.0
    measurement.arrays["deformed_position"][bare] += 1.0  # there, but wrong
    found = compare_with_truth(measurement, truth, yardstick=YARDSTICK)
    gone = (8.2**2 + 5.2**2) / 33.5**2  # points reach 1 mm less the spacing into both discs
    assert found["coverage"] == pytest.approx(1 - gone, abs=0.02)
    assert found["ok_points"] == found["points"] - lost.sum()
    assert found["wrong_points"] == bare.sum()


def test_damaged_material_does_not_count_as_visible():
    truth = _truth(damage=(DamageSpot("lost_patch", np.array([10.0, -5.0]), 10.0),))
    measurement, exact = _perfect(truth)
    measurement.arrays["status"][~exact.visible] = 6
    found = compare_with_truth(measurement, truth, yardstick=YARDSTICK)
    assert found["visible_coverage"] == pytest.approx(1.0, abs=0.002)
    assert found["coverage"] < 0.95


def test_strains_beside_a_kink_are_left_out():
    truth = _truth()
    measurement, exact = _perfect(truth)
    measurement.arrays["E1"][exact.kink_distance < 1.4] += 0.5
    measurement.arrays["E2"] += 0.002
    found = compare_with_truth(measurement, truth, yardstick=YARDSTICK)
    assert found["dE1"]["max"] < 1e-10
    assert found["dE2"]["median"] == pytest.approx(0.002)


def test_another_truth_and_an_empty_field_are_refused():
    truth = _truth()
    measurement, _ = _perfect(truth)
    posed = RigidTransform(truth.reference_pose.rotation, truth.reference_pose.translation + 20.0)
    other = make_truth(
        "bulge", size=70.0, offset=0.0, tilt=0.0, poses=(posed, truth.deformed_pose), damage=()
    )
    with pytest.raises(DataError, match=r"off the surface of this truth"):
        compare_with_truth(measurement, other, yardstick=YARDSTICK)
    measurement.arrays["status"][:] = 5
    with pytest.raises(DataError, match=r"none of \d+ points is OK"):
        compare_with_truth(measurement, truth, yardstick=YARDSTICK)


def test_share_within_sigma_is_that_of_the_errors_that_were_put_in():
    rng = np.random.default_rng(5)
    truth = _truth()
    measurement, exact = _perfect(truth)
    count = len(exact.material)
    edges = [
        truth_of_material(truth, exact.material + 1e-4 * axis).reference - exact.reference
        for axis in np.eye(2)
    ]
    basis = np.stack(edges, axis=1) / np.linalg.norm(edges, axis=2).T[:, :, None]
    tensor = true_tensor(truth, exact.reference, basis)
    error = rng.normal(size=(count, 3))
    moved = 0.01 * rng.normal(size=(count, 3))
    arrays = measurement.arrays | {
        "displacement": measurement.arrays["displacement"] + moved,
        "sigma_uvw": np.full((count, 3), 0.01) * [1, 2, 1],
        "E_tangent": np.stack([tensor[:, 0, 0], tensor[:, 1, 1], tensor[:, 0, 1]], 1) + error,
        "sigma_E_tangent": np.ones((count, 3)),
        "tangent_1": basis[:, 0],
        "tangent_2": basis[:, 1],
        "direction_1": np.full((count, 3), np.nan),
        "sigma_E1": np.ones(count),
        "sigma_E2": np.ones(count),
    }
    full = Measurement(measurement.reference, measurement.cells, arrays)
    found = compare_with_truth(full, truth, yardstick=YARDSTICK)["within_sigma"]
    assert set(found) == {"u", "v", "w", "E_11", "E_22", "E_12"}  # no point has a direction
    for name in ("u", "w", "E_11", "E_22", "E_12"):
        assert found[name] == pytest.approx(0.683, abs=0.03), name
    assert found["v"] == pytest.approx(0.954, abs=0.02)
    assert compare_with_truth(measurement, truth, yardstick=YARDSTICK)["within_sigma"] == {}
