"""docs/python.md: every example runs, and what it says is so."""

import gc
import re
import shutil
from pathlib import Path
from tempfile import gettempdir

import numpy as np
import pytest

import shapemorph as sm
from shapemorph import api
from shapemorph.api import Result
from shapemorph.cli import main
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.core.measurement import Measurement

PAGE = Path(__file__).parents[2] / "docs" / "python.md"
SMALL = ("faces=4000", "texture=512", "speckle=1.6", "vertex_noise=0.004")


@pytest.fixture(scope="session")
def small_pair(tmp_path_factory):
    """Folder with before.obj and after.obj: a bulge of few faces."""
    folder = tmp_path_factory.mktemp("small")
    words = [word for text in SMALL for word in ("--set", f"synthesize.{text}")]
    assert main(["synthesize", "bulge", "-o", str(folder / "case"), *words, "--quiet"]) == 0
    for name, side in (("before", "reference"), ("after", "deformed")):
        (folder / f"{name}.obj").write_text((folder / "case" / f"{side}.obj").read_text())
        for suffix in ("mtl", "png"):
            source = folder / "case" / f"{side}.{suffix}"
            (folder / source.name).write_bytes(source.read_bytes())
    return folder


@pytest.fixture(scope="session")
def result(small_pair):
    """Result of the small pair; read only."""
    return sm.measure(small_pair / "before.obj", small_pair / "after.obj")


@pytest.mark.slow
@pytest.mark.render
def test_every_example_runs(small_pair, monkeypatch, capsys):
    monkeypatch.chdir(small_pair)
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) >= 7
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)
    said = capsys.readouterr().out
    assert "window must be odd, got 4" in said
    assert (small_pair / "RUN" / "report.html").is_file()
    assert (small_pair / "E1.png").stat().st_size > 10_000


def test_arrays_are_attributes_and_items(result):
    assert result.E1 is result["E1"]
    assert result.displacement.shape == result.points.shape
    assert "E1" in dir(result)
    assert "PASS" in repr(result)
    with pytest.raises(AttributeError, match=r"no 'E3'.*E1, E2"):
        _ = result.E3
    with pytest.raises(KeyError, match="E3"):
        _ = result["E3"]


def test_the_surface_lies_in_the_frame_of_the_reference(result):
    deformed, reference = result.to_pyvista(), result.to_pyvista("reference")
    ok = result.status == 0
    np.testing.assert_allclose(
        np.asarray(deformed.points)[ok], (result.points + result.displacement)[ok], rtol=1e-12
    )
    np.testing.assert_array_equal(reference.points, result.points)
    np.testing.assert_array_equal(deformed.point_data["E1"], result.E1)
    assert deformed.n_cells == len(result.cells)


def test_a_run_without_a_place_of_its_own_is_gone_with_its_result(result, tmp_path, monkeypatch):
    copy = tmp_path / "copy"
    shutil.copytree(result.folder, copy)
    np.testing.assert_array_equal(sm.load(copy).E1, result.E1)
    assert not (copy / "figures").exists()
    homes = set(Path(gettempdir()).glob("shapemorph-*"))
    monkeypatch.setattr(api, "_measured", lambda folder, *_: Result(folder, field, {}))
    field = Measurement(result.points, result.cells, {})
    passing = sm.measure("a.obj", "b.obj")
    assert passing.folder.parent.is_dir()
    del passing
    gc.collect()
    assert set(Path(gettempdir()).glob("shapemorph-*")) == homes


def test_what_is_no_scalar_is_refused_with_what_is(result):
    with pytest.raises(ConfigError, match=r"E1.*got 'direction_1'"):
        result.plot("direction_1")
    with pytest.raises(ConfigError, match="reference or deformed"):
        result.plot("E1", state="morphed")


def test_what_is_no_run_is_an_error_of_data(tmp_path):
    with pytest.raises(DataError, match=r"measurement\.vtp"):
        sm.load(tmp_path)


def test_unknown_settings_are_refused_before_anything_is_read(tmp_path):
    with pytest.raises(ConfigError, match=r"strain\.window"):
        sm.measure("a.obj", "b.obj", output=tmp_path / "run", strain={"windw": 5})
    assert not (tmp_path / "run").exists()
