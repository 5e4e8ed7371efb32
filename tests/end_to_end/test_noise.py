"""The noise floor of a small rigid pair: measured, printed, stored."""

import json

import pytest

from shapemorph.cli import main

SMALL = ("faces=4000", "texture=512", "speckle=1.6", "vertex_noise=0.004")


@pytest.fixture(scope="session")
def rigid_pair(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rigid") / "case"
    words = [word for text in SMALL for word in ("--set", f"synthesize.{text}")]
    assert main(["synthesize", "rigid", "-o", str(folder), *words]) == 0
    return folder


def test_observed_noise_is_near_what_was_predicted(rigid_pair, tmp_path, capsys):
    run = tmp_path / "run"
    meshes = [str(rigid_pair / f"{side}.obj") for side in ("reference", "deformed")]
    words = ["noise", *meshes, "-o", str(run), "--set", "report.figures=false", "--quiet"]
    assert main(words) == 0
    said = capsys.readouterr().out
    stored = json.loads((run / "noise.json").read_text(encoding="utf-8"))
    for meaning in stored["definitions"].values():
        assert meaning in said
    figures = stored["figures"]
    for name in ("u", "v", "w", "E1", "E2"):
        # one surface is one draw of noise that is alike over several points: a third at most
        assert figures[name]["ratio"] == pytest.approx(1, abs=0.33), name
    assert figures["u"]["mean"] == pytest.approx(0, abs=1e-9)
    assert not [note for note in stored["notes"] if "one state" in note]
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["figures"] == figures


def test_a_pair_that_was_deformed_is_doubted(pair, tmp_path, capsys):
    meshes = [str(pair / f"{side}.obj") for side in ("reference", "deformed")]
    words = ["-o", str(tmp_path / "run"), "--set", "report.figures=false", "--quiet", "--json"]
    assert main(["noise", *meshes, *words]) == 0
    notes = json.loads(capsys.readouterr().out)["notes"]
    assert any("two scans of one state" in note for note in notes)
