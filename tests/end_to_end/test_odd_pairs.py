"""Pairs that people try: the same file twice, the two swapped, colours instead of a texture."""

import json

import numpy as np
import pytest

from shapemorph.cli import main
from shapemorph.core.status import PointStatus
from shapemorph.io.measurement_files import read_csv

pytestmark = pytest.mark.slow


def _measured(capsys, reference, deformed, folder):
    words = ["measure", str(reference), str(deformed), "-o", str(folder), "--json", "--quiet"]
    assert main([*words, "--set", "report.figures=false"]) == 0
    return json.loads(capsys.readouterr().out), read_csv(folder / "measurement.csv")


def test_a_file_measured_against_itself_has_not_moved(pair, tmp_path, capsys):
    file = pair / "reference.obj"
    found, table = _measured(capsys, file, file, tmp_path / "run")
    assert found["verdict"] == {"level": "PASS", "reasons": []}
    assert found["points"]["ok_share"] > 0.99
    moved = np.hypot(np.hypot(table["u_mm"], table["v_mm"]), table["w_mm"])
    # Nothing is noisy between the two, so what is left is where the iterations stop: a
    # thousandth of a pixel, and pixels are about 0.14 mm.
    assert np.nanmedian(moved) < 1e-5
    assert np.nanmax(moved) < 1e-3
    assert np.nanmax(np.abs(table["E1"])) < 1e-3


def test_swapped_files_give_the_inverse_stretch(pair, measured, tmp_path, capsys):
    files = (pair / "deformed.obj", pair / "reference.obj")
    found, back = _measured(capsys, *files, tmp_path / "run")
    assert found["verdict"]["level"] == "PASS"
    forth = read_csv(measured / "measurement.csv")
    # What was stretched by sqrt(1 + 2 E1) one way is shortened by as much the other way, so
    # the largest E1 answers to the smallest E2. The pole itself is blurred by both gauges.
    stretch = np.sqrt(1 + 2 * np.nanpercentile(forth["E1"], 99))
    shortening = np.sqrt(1 + 2 * np.nanpercentile(back["E2"], 1))
    assert stretch > 1.8
    assert stretch * shortening == pytest.approx(1, abs=0.05)


def test_colours_at_vertices_are_measured_as_a_texture_is(tmp_path, capsys):
    settings = {"format": "ply", "faces": 60000, "size": 50, "speckle": 2, "texture": 64}
    words = [
        word for key, value in settings.items() for word in ("--set", f"synthesize.{key}={value}")
    ]
    assert main(["synthesize", "bulge", "-o", str(tmp_path), "--quiet", *words]) == 0
    capsys.readouterr()
    files = (tmp_path / "reference.ply", tmp_path / "deformed.ply")
    found, table = _measured(capsys, *files, tmp_path / "run")
    assert found["inputs"]["reference"]["file_format"] == "PLY"
    assert found["verdict"]["level"] == "PASS"
    assert (table["status"] == PointStatus.OK).mean() > 0.95
    assert main(["compare", str(tmp_path / "run"), str(tmp_path), "--json"]) == 0
    errors = json.loads(capsys.readouterr().out)
    # Vertices are 0.3 mm apart: an eighth of that is what linear colour between them leaves.
    assert errors["wrong_points"] == 0
    assert errors["error_mm"]["median"] < 0.04
    assert errors["coverage"] > 0.8
