"""`compare` from files to lines of text."""

import json

import numpy as np
import pytest

from shapemorph.core.errors import DataError
from shapemorph.core.measurement import Measurement
from shapemorph.io.measurement_files import write_vtp
from shapemorph.io.truth_files import write_truth
from shapemorph.methods.synthetic.sides import random_pose
from shapemorph.methods.synthetic.truth import make_truth, random_material, truth_of_material
from shapemorph.pipeline.compare import compare, comparison_lines


def _run(folder, size, error):
    poses = (
        random_pose(size, np.random.default_rng(0)),
        random_pose(size, np.random.default_rng(1)),
    )
    truth = make_truth("hole", size=size, offset=0.0, tilt=0.0, poses=poses, damage=())
    exact = truth_of_material(truth, random_material(truth, 15_000, inset=0.0, seed=1))
    count = len(exact.material)
    deformed = exact.deformed + error * np.array([0.0, 1.0, 0.0])
    back = truth.deformed_pose.inverse().apply(exact.deformed)
    arrays = {
        "status": np.zeros(count, dtype=np.uint8),
        "deformed_position": deformed,
        "displacement": truth.reference_pose.apply(back) - exact.reference,
        "E1": exact.e1 + 0.001,
        "E2": exact.e2,
    }
    measurement = Measurement(exact.reference, np.zeros((0, 4), dtype=np.int64), arrays)
    write_vtp(folder / "measurement.vtp", measurement, {})
    write_truth(folder / "truth.npz", truth)


def test_errors_are_read_from_the_files_and_are_json(tmp_path):
    _run(tmp_path, 70.0, 0.004)
    found = compare(tmp_path, tmp_path / "truth.npz")
    assert found["error_mm"]["median"] == pytest.approx(0.004, abs=1e-6)
    assert found["dE1"]["p95"] == pytest.approx(0.001, abs=1e-6)
    assert found["coverage"] > 0.999
    assert json.loads(json.dumps(found)) == found


def test_limits_scale_with_the_object_and_both_stand_in_the_table(tmp_path):
    _run(tmp_path, 7.0, 0.05)  # 0.5 mm on an object of 70 mm
    found = compare(tmp_path, tmp_path)
    assert found["wrong_limit_mm"] == pytest.approx(0.025)
    assert found["reach_mm"] == pytest.approx(0.1)
    assert found["wrong_points"] == found["ok_points"]
    assert found["wrong_points_fixed"] == 0
    lines = comparison_lines(found)
    assert any("off by > 0.025 mm" in line and "100.000 %" in line for line in lines)
    assert any("off by > 0.25 mm" in line and "0 points" in line for line in lines)


def test_lines_name_the_measure_and_the_unit(tmp_path):
    _run(tmp_path, 70.0, 0.004)
    text = "\n".join(comparison_lines(compare(tmp_path, tmp_path)))
    assert "median 4.00 um" in text
    assert "Green-Lagrange" in text
    assert text.count("off by >") == 1  # one limit at 70 mm


def test_missing_files_are_named(tmp_path):
    with pytest.raises(DataError, match=r"found no measurement\.vtp"):
        compare(tmp_path, tmp_path / "truth.npz")
    _run(tmp_path, 70.0, 0.0)
    with pytest.raises(DataError, match=r"found no file .*elsewhere"):
        compare(tmp_path, tmp_path / "elsewhere.npz")
