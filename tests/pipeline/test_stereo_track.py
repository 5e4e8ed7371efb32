"""The three methods on a small synthetic membrane, against its truth."""

import json
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from shapemorph.config import RunConfig, TwinConfig
from shapemorph.core.errors import DataError
from shapemorph.io.config_files import read_config
from shapemorph.io.measurement_files import read_vtp
from shapemorph.io.twin_files import read_twin
from shapemorph.methods.synthetic.membrane.smooth import map_points
from shapemorph.pipeline.stereo_track import track_stereo
from shapemorph.pipeline.twin import write_twin_case

CONFIGS = Path(__file__).parents[2] / "configs"
SMALL = TwinConfig(
    law="analytic", scale=0.2, steps=2, travel=10.0, rings=16, views=0, samples=2, noise=1.0
)


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    folder = tmp_path_factory.mktemp("twin")
    write_twin_case(SMALL, folder, listener=lambda _: None)
    return folder


def settings(case, method, **more):
    inputs = {
        "left": case / "left_*.png",
        "right": case / "right_*.png",
        "rig": case / "rig.json",
        "region": {"mask": case / "mask_left.png"},
    }
    correlate = {"order": 2, "subset_size": 21, "spacing": 7}
    track, report = {"method": method, **more}, {"figures": False}
    return RunConfig(inputs=inputs, track=track, correlate=correlate, report=report)


def errors(case, folder):
    """Displacement of OK points less the truth, (N, 3), mm."""
    twin = read_twin(case / "truth.npz")
    measured, _ = read_vtp(folder / "measurement.vtp")
    ok = measured.arrays["status"] == 0
    material = measured.reference[ok, :2]  # the flat sheet lies in z = 0
    truth = map_points(twin.maps[-1], material)[0] - map_points(twin.maps[0], material)[0]
    return measured.arrays["displacement"][ok] - truth


@pytest.mark.parametrize("method", ["incremental", "image_morphing", "shape_morphing"])
def test_each_method_finds_the_displacement(case, tmp_path, method):
    folder = tmp_path / "run"
    found = track_stereo(settings(case, method), folder, listener=lambda _: None)
    off = errors(case, folder)
    assert len(off) > 900
    assert found.summary["points"]["ok_share"] > 0.9
    limits = np.array([0.02, 0.02, 0.05])  # mm; a pixel shows 0.25 mm
    assert (np.abs(np.median(off, axis=0)) < 0.3 * limits).all()
    assert (1.4826 * np.median(np.abs(off), axis=0) < limits).all()


@pytest.mark.parametrize("method", ["incremental", "image_morphing"])
def test_the_settings_of_the_paper_give_errors_of_its_order(case, tmp_path, method):
    text = (CONFIGS / f"paper_{method}.yaml").read_text(encoding="utf-8")
    (case / "paper.yaml").write_text(text, encoding="utf-8")
    config = read_config(case / "paper.yaml", RunConfig, ())
    assert config.correlate.mode == "paper"
    track_stereo(config, tmp_path / "run", listener=lambda _: None)
    off = errors(case, tmp_path / "run")
    assert len(off) > 900
    scatter = 1.4826 * np.median(np.abs(off), axis=0)
    assert (scatter < 5 * np.array([0.04, 0.04, 0.13])).all()  # 0.25 mm/px, the paper 0.05


def test_every_state_lies_on_one_mesh(case, tmp_path):
    folder = tmp_path / "run"
    track_stereo(settings(case, "incremental", temporal=True), folder, listener=lambda _: None)
    entries = ET.parse(folder / "measurement.pvd").getroot()[0]
    assert [entry.get("timestep") for entry in entries] == ["1", "2"]
    surfaces = [read_vtp(folder / str(entry.get("file")))[0] for entry in entries]
    np.testing.assert_array_equal(surfaces[0].reference, surfaces[1].reference)
    heights = [np.nanmax(surface.arrays["displacement"][:, 2]) for surface in surfaces]
    assert heights == pytest.approx([5.0, 10.0], abs=0.3)


def test_a_missing_picture_is_missed(case, tmp_path):
    config = settings(case, "incremental")
    inputs = config.inputs.model_copy(update={"right": case / "right_0[01].png"})
    with pytest.raises(DataError, match=r"got 3 of .* and 2 of .*: is a picture missing"):
        track_stereo(
            config.model_copy(update={"inputs": inputs}), tmp_path, listener=lambda _: None
        )


def test_a_calibration_of_another_size_is_refused(case, tmp_path):
    rig = json.loads((case / "rig.json").read_text(encoding="utf-8"))
    for camera in rig["cameras"]:
        camera["size_px"] = [800, 600]
    (tmp_path / "rig.json").write_text(json.dumps(rig), encoding="utf-8")
    config = settings(case, "incremental")
    inputs = config.inputs.model_copy(update={"rig": tmp_path / "rig.json"})
    with pytest.raises(DataError, match=r"left_00\.png: expected 800 x 600 px as the left camera"):
        track_stereo(
            config.model_copy(update={"inputs": inputs}), tmp_path / "run", listener=lambda _: None
        )
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("method", ["incremental", "image_morphing"])
def test_swapped_cameras_are_noticed_before_anything_is_followed(case, tmp_path, method):
    config, steps = settings(case, method), []
    inputs = config.inputs.model_copy(
        update={
            "left": config.inputs.right,
            "right": config.inputs.left,
            "region": None,
        }
    )
    with pytest.raises(DataError, match="cameras swapped"):
        track_stereo(config.model_copy(update={"inputs": inputs}), tmp_path, listener=steps.append)
    begun = [step.name for step in steps if step.state == "started"]
    assert not [name for name in begun if name.startswith("state")]
    assert begun.count("correlate") <= 1
