"""The files of a synthetic sheet on a turntable."""

import numpy as np
import pytest

from shapemorph.cli.main import main
from shapemorph.config import RigConfig, TurnConfig
from shapemorph.io.config_files import read_config
from shapemorph.io.fe_files import read_finite_elements
from shapemorph.io.landmarks import read_landmarks
from shapemorph.io.target_files import read_target


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("bulge") / "twin"
    small = ["scale=0.15", "frames=2", "rings=8", "samples=1"]
    settings = [word for each in small for word in ("--set", f"twin.{each}")]
    assert main(["synthesize", "stereo", "bulge", "-o", str(place), "--quiet", *settings]) == 0
    return place


def test_each_state_has_pictures_masks_and_what_they_show(folder):
    for state in ("before", "after"):
        names = {path.name for path in (folder / state).iterdir()}
        pictures = {f"{kind}_00{k}.png" for kind in ("frame", "mask") for k in range(2)}
        assert names == pictures | {"rig.yaml", "turn.yaml"}
        rig = read_config(folder / state / "rig.yaml", RigConfig, [])
        assert rig.targets["cone"].least_px == pytest.approx(4.3)
        turn = read_config(folder / state / "turn.yaml", TurnConfig, [])
        assert turn.angle == pytest.approx(31.4, abs=0.1)  # 45 degrees of the turn, seen slanted


def test_marks_law_and_truth_agree(folder):
    marks = read_landmarks(folder / "landmarks.csv", reference_scale=1.0, deformed_scale=1.0)
    assert len(marks.names) == 3
    law = read_finite_elements(
        folder / "law.csv", scale=1.0, model="solid", moved=None, displacement=None
    )
    assert law.material[-1] == pytest.approx(30.0)
    assert len(read_target(folder / "cone.csv").points) == 166
    with np.load(folder / "truth.npz") as truth:
        assert truth["camera_from_part"].shape == (2, 4, 4)
        assert truth["coefficients"].shape[0] == 2
        assert float(truth["radius"]) == 22.5


def test_a_turn_needs_two_frames(capsys, tmp_path):
    out = str(tmp_path / "out")
    assert main(["synthesize", "stereo", "bulge", "-o", out, "--set", "twin.frames=1"]) == 2
    assert "two or more frames" in capsys.readouterr().err
