"""Regions and landmarks through the whole path, on copies of one finished run."""

import csv
import json
import shutil

import numpy as np
import pytest

from shapemorph.cli import main
from shapemorph.core.status import PointStatus
from shapemorph.io.images import read_grey_image, write_grey_png
from shapemorph.io.measurement_files import read_vtp
from shapemorph.io.truth_files import read_truth

pytestmark = pytest.mark.slow

CORRELATE_ON = ["correlate", "lift", "spread", "align", "strain"]


@pytest.fixture
def folder(measured, tmp_path):
    """A finished run that may be changed."""
    shutil.copytree(measured, tmp_path / "run")
    return tmp_path / "run"


def _change(folder, capsys, *settings):
    words = [word for setting in settings for word in ("--set", setting)]
    assert main(["run", str(folder), *words, "--json", "--quiet"]) == 0
    return json.loads(capsys.readouterr().out), read_vtp(folder / "measurement.vtp")[0]


def test_a_ball_limits_the_points_to_its_inside(folder, capsys):
    points = read_vtp(folder / "measurement.vtp")[0].reference
    centre = points[len(points) // 2]
    where = ", ".join(f"{x:.6f}" for x in centre)
    found, field = _change(folder, capsys, f"inputs.region={{centre: [{where}], radius: 12}}")
    assert found["run"]["ran"] == CORRELATE_ON
    distance = np.linalg.norm(field.reference - centre, axis=1)
    assert 11 < distance.max() <= 12.0 + 1e-6
    inside = np.linalg.norm(points - centre, axis=1) < 11.9
    assert len(field.reference) >= inside.sum()
    assert found["coverage"]["share_of_surface"] < 0.2
    assert found["coverage"]["share_of_region"] > 0.95


def test_a_mask_picture_limits_the_points_to_its_white(folder, tmp_path, capsys):
    shape = read_grey_image(folder / "flatten" / "reference.png").shape
    white = np.zeros(shape, "f4")
    white[: shape[0] // 3, shape[1] // 2 :] = 1.0
    write_grey_png(tmp_path / "mask.png", white, np.ones(shape, bool))
    found, field = _change(folder, capsys, f"inputs.region={{mask: {tmp_path / 'mask.png'}}}")
    assert found["run"]["ran"] == CORRELATE_ON
    x, y = field.arrays["reference_px"].T
    assert (x >= shape[1] // 2).all()
    assert (y < shape[0] // 3).all()
    assert (field.arrays["status"] == PointStatus.OK).mean() > 0.9


def test_a_mask_of_another_size_is_one_clear_line(folder, tmp_path, capsys):
    write_grey_png(tmp_path / "mask.png", np.ones((9, 9), "f4"), np.ones((9, 9), bool))
    setting = f"inputs.region={{mask: {tmp_path / 'mask.png'}}}"
    code = main(["run", str(folder), "--set", setting, "--quiet"])
    line = capsys.readouterr().err
    assert code in {2, 3}
    assert line.count("\n") == 1
    assert "9" in line


def test_landmarks_carry_the_alignment_and_strain_stays(folder, pair, tmp_path, capsys):
    before = read_vtp(folder / "measurement.vtp")[0].arrays["E1"]
    table = read_truth(pair / "truth.npz").table
    flange = np.flatnonzero((table.rim_distance > 1) & (table.rim_distance < 5) & (table.e1 < 1e-6))
    chosen = flange[:: len(flange) // 6][:6]
    path = tmp_path / "landmarks.csv"
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["name", "ref_x", "ref_y", "ref_z", "def_x", "def_y", "def_z"])
        for row in chosen:
            writer.writerow([f"p{row}", *table.reference[row], *table.deformed[row]])
    found, field = _change(folder, capsys, f"inputs.landmarks={path}")
    assert "flatten" not in found["run"]["ran"]
    assert found["match"]["manner"].startswith("features")  # marks help where these are too few
    assert found["align"]["method"] == "landmarks"
    assert found["align"]["rms_mm"] < 1e-6  # the points are exact
    assert len(found["align"]["landmark_residuals_mm"]) == 6
    np.testing.assert_array_equal(field.arrays["E1"], before)


def test_a_rigid_region_limits_what_carries_the_alignment(folder, capsys):
    points = read_vtp(folder / "measurement.vtp")[0]
    still = np.argmin(np.nan_to_num(np.abs(points.arrays["E1"]), nan=9.0))
    where = ", ".join(f"{x:.6f}" for x in points.reference[still])
    setting = f"align.rigid_region={{centre: [{where}], radius: 8}}"
    found, _ = _change(folder, capsys, setting)
    assert found["run"]["ran"] == ["align"]
    assert 3 < found["align"]["carried_by"] < 0.2 * found["points"]["ok"]


def test_other_flattenings_and_subsets_tell_the_systematic_part(folder, capsys):
    found, _ = _change(folder, capsys, "spread.flattenings=[lscm]", "spread.subset_sizes=[25]")
    assert found["run"]["ran"] == ["spread"]
    variants = found["systematic"]["variants"]
    assert set(variants) == {"flatten.method=lscm", "correlate.subset_size=25"}
    for variant in variants.values():
        assert variant["points_compared"] > 0.9 * found["points"]["ok"]
        assert variant["position_rms_mm"] < 0.02
        assert variant["E1_rms"] < 0.02
    largest = max(variant["position_rms_mm"] for variant in variants.values())
    assert found["systematic"]["position_rms_mm"] == largest
