"""Public photographs of calibration targets."""

import json

import pytest
import yaml

from shapemorph.cli.main import main

pytestmark = pytest.mark.slow


def calibrated(document, folder):
    path = folder / "rig.yaml"
    path.write_text(yaml.safe_dump(document))
    words = ["calibrate", str(path), "-o", str(folder / "out"), "--quiet"]
    assert main([*words, "--set", "report.figures=false"]) == 0
    return json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))


def test_a_stereo_pair_of_a_chessboard(shared_data, tmp_path):
    data = shared_data("opencv_stereo_checkerboard")
    found = calibrated(
        {
            "cameras": ["left", "right"],
            "targets": {"board": {"kind": "chessboard", "columns": 9, "rows": 6, "spacing": 1}},
            "views": [
                {
                    "target": "board",
                    "pictures": {"left": f"{data}/left*.jpg", "right": f"{data}/right*.jpg"},
                }
            ],
        },
        tmp_path,
    )
    assert not found["rejected"]
    assert found["pairs"][0]["rms_px"] <= 0.22
    assert found["pairs"][0]["baseline_mm"] == pytest.approx(3.327, rel=0.005)


def test_boards_seen_apart_tied_by_a_cylinder(shared_data, tmp_path):
    data = shared_data("multidic_cylinder")
    solid = data / "calibration_cylinder"
    found = calibrated(
        {
            "cameras": ["201", "202"],
            "targets": {
                "board": {"kind": "chessboard", "columns": 19, "rows": 14, "spacing": 10},
                "cylinder": {
                    "kind": "points",
                    "points": str(solid / "calibrationObjectCoordinates.csv"),
                    "dot_diameter": 4,
                    "dot_shape": "square",
                },
            },
            "views": [
                {
                    "target": "board",
                    "simultaneous": False,
                    "pictures": {
                        name: f"{data}/checkerboard/{name}/{name}_*.jpg" for name in ("201", "202")
                    },
                },
                {
                    "target": "cylinder",
                    "pictures": {name: f"{solid}/{name}.jpg" for name in ("201", "202")},
                    "anchors": {
                        "201": [[20, 6, 1214, 446], [1, 6, 1214, 2606]],
                        "202": [[20, 8, 1110, 410], [1, 8, 1076, 2580]],
                    },
                },
            ],
        },
        tmp_path,
    )
    (cylinder,) = found["control_points"]
    assert cylinder["points"] > 100
    assert cylinder["mean_mm"] <= 0.05
    assert found["cameras"]["201"]["rms_px"] < 0.5
