"""`flatten MESH`: every file that it writes, and every way to ask for a method."""

import json
import shutil

import numpy as np
import pytest
from PIL import Image

from shapemorph.cli.words import describe_flattening
from shapemorph.config import RunConfig, SynthesizeConfig
from shapemorph.core.errors import ConfigError
from shapemorph.io.config_files import check_config
from shapemorph.io.meshes import read_mesh
from shapemorph.pipeline.inputs import Inputs
from shapemorph.pipeline.one_mesh import flatten_one
from shapemorph.pipeline.synthesize import write_case


@pytest.fixture(scope="module")
def shell(tmp_path_factory):
    folder = tmp_path_factory.mktemp("case")
    config = SynthesizeConfig(shape="dome", faces=3000, texture=512, speckle=2.5)
    write_case(config, folder)
    return folder / "deformed.obj"


def _flatten(shell, folder, *settings):
    config = check_config({}, RunConfig, settings)
    return flatten_one(shell, folder, config, listener=lambda _: None)


def test_it_writes_picture_volume_mesh_and_distortion(shell, tmp_path):
    outcome = _flatten(shell, tmp_path, "flatten.method=profile")
    names = {path.name for path in tmp_path.iterdir()}
    stem = "deformed"
    assert names == {
        *(f"{stem}{suffix}" for suffix in (".png", ".vti", ".npz")),
        *(f"{stem}_uv{suffix}" for suffix in (".obj", ".mtl", ".png")),
        *("distortion.json", "distortion.png", "summary.json"),
    }
    assert {path.name for path in outcome.files} == names
    with Image.open(tmp_path / "distortion.png") as picture:
        colours = picture.convert("RGB").getcolors(1 << 24)
    assert len(colours) > 200


def test_the_obj_is_the_surface_of_the_file_and_opens_again(shell, tmp_path):
    _flatten(shell, tmp_path, "report.figures=false", "inputs.units=cm")
    original, _ = read_mesh(shell, unit="cm")
    again, _ = read_mesh(tmp_path / "deformed_uv.obj", unit="cm")
    assert len(again.faces) == len(original.faces)
    for bound in (np.min, np.max):
        np.testing.assert_allclose(
            bound(again.vertices, axis=0), bound(original.vertices, axis=0), atol=1e-3
        )
    assert not (tmp_path / "distortion.png").exists()


def test_the_distortion_is_told_by_shares_of_area(shell, tmp_path):
    _flatten(shell, tmp_path, "flatten.method=spherical", "report.figures=false")
    found = json.loads((tmp_path / "distortion.json").read_text())
    assert found["method"] == "spherical"
    assert found["flipped_triangles"] == 0
    scale = found["local_px_per_mm"]
    assert scale["p1"] < scale["median"] < scale["p99"]
    # a half ball on a wall: an equidistant map stretches the rim by up to 2.3 : 1
    assert 1.8 < found["anisotropy"]["p99"] < 3.0


def test_a_meridian_from_a_file_is_used(shell, tmp_path):
    polar = np.linspace(0, np.pi / 2, 60)
    rows = [*zip(35 * np.sin(polar), 35 * np.cos(polar), strict=True), (35.0, -15.0)]
    path = tmp_path / "fe.csv"
    path.write_text("r,z\n" + "".join(f"{r:.6f},{z:.6f}\n" for r, z in rows))
    settings = ("flatten.method=profile", f"flatten.profile={path}", "report.figures=false")
    outcome = _flatten(shell, tmp_path / "out", *settings)
    assert "by the given meridian" in outcome.summary["flatten"]["reason"]


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        (("flatten.axis=[0,0,1]",), "axis is for method orthographic, spherical"),
        (("flatten.method=slim", "flatten.centre=[0,0,1]"), "centre is for method spherical"),
        (("flatten.method=profile", "flatten.projection=equal_area"), "projection is for method"),
        (("flatten.method=bff", "flatten.profile=a.csv"), "profile is for method profile"),
        (("flatten.method=spheric",), "method"),
    ],
)
def test_a_parameter_that_the_method_does_not_use_is_an_error(settings, says):
    with pytest.raises(ConfigError, match=says):
        check_config({}, RunConfig, settings)


def test_the_content_of_the_meridian_is_part_of_the_recipe(shell, tmp_path):
    def mark(name, text, units="mm"):
        (tmp_path / name).write_text(text)
        document = {
            "inputs": {"reference": str(shell), "deformed": str(shell), "units": units},
            "flatten": {"method": "profile", "profile": str(tmp_path / name)},
        }
        inputs = Inputs(RunConfig.model_validate(document))
        assert tmp_path / name in inputs.files()
        return inputs.fingerprint("meridian"), inputs.load("meridian")

    one, points = mark("a.csv", "r,z\n0,1\n2,0\n")
    assert mark("b.csv", "r,z\n0,1\n2,0\n")[0] == one
    assert mark("c.csv", "r,z\n0,1\n2,0.5\n")[0] != one
    other, in_mm = mark("d.csv", "r,z\n0,1\n2,0\n", units="cm")
    assert other != one
    np.testing.assert_allclose(in_mm, 10 * points)


def test_the_texture_of_the_mesh_is_never_written_over(shell):
    picture = shell.with_suffix(".png")
    before = {path.name: path.read_bytes() for path in shell.parent.iterdir()}
    with pytest.raises(ConfigError, match=rf"{picture.name} would be written over"):
        _flatten(shell, shell.parent, "report.figures=false")
    assert {path.name: path.read_bytes() for path in shell.parent.iterdir()} == before


def test_what_was_cleaned_is_told(shell, tmp_path):
    mesh = tmp_path / "in" / "odd.obj"
    shutil.copytree(shell.parent, mesh.parent)
    text = shell.read_text()
    mesh.write_text(f"{text}v 900 0 0\nv 901 0 0\nv 900 1 0\nf -3/1 -2/2 -1/3\n")
    outcome = _flatten(mesh, tmp_path / "out", "report.figures=false")
    told = "\n".join(describe_flattening(outcome.folder, outcome.summary))
    assert "1 faces of the others were dropped" in told
