"""A run folder over many visits, with cheap stages in place of the real ones."""

import contextlib
import dataclasses
import errno

import numpy as np
import pytest

from shapemorph.config import RunConfig
from shapemorph.core.errors import ConfigError, DataError, StageError
from shapemorph.core.image import GreyImage
from shapemorph.pipeline import measure as order
from shapemorph.pipeline.inputs import Inputs
from shapemorph.pipeline.outputs import OUTPUTS, Finished
from shapemorph.pipeline.stagelist import COMPUTED, STAGES


class Workshop:
    """A folder with two input files, and what stages do in it."""

    def __init__(self, folder, monkeypatch):
        self.folder = folder
        self.run_folder = folder / "run"
        self.failing = {}
        self.loaded = []
        (folder / "a.obj").write_text("first")
        (folder / "b.obj").write_text("second")
        stages = tuple(dataclasses.replace(s, run=self._stage(s.name)) for s in STAGES)
        outputs = tuple(dataclasses.replace(o, write=self._output(o.name)) for o in OUTPUTS)
        monkeypatch.setattr(order, "STAGES", stages)
        monkeypatch.setattr(order, "OUTPUTS", outputs)
        monkeypatch.setattr(Finished, "drawing", lambda *_, **__: contextlib.nullcontext())
        monkeypatch.setattr(Inputs, "load", lambda _, name: self.loaded.append(name))

    def measure(self, until=None, force=(), **sections):
        config = RunConfig.model_validate(
            {
                "inputs": {
                    "reference": str(self.folder / "a.obj"),
                    "deformed": str(self.folder / "b.obj"),
                },
                **sections,
            }
        )
        self.loaded.clear()
        outcome = order.measure(
            config, self.run_folder, until=until, force=force, listener=lambda _: None
        )
        return list(outcome.ran), list(outcome.written)

    def files(self):
        return {p.relative_to(self.run_folder).as_posix() for p in self.run_folder.rglob("*.txt")}

    def ages(self):
        return {p.name: p.stat().st_mtime_ns for p in self.run_folder.rglob("*") if p.is_file()}

    def _stage(self, name):
        def run(*_):
            if name in self.failing:
                raise self.failing[name]
            return GreyImage(np.zeros((2, 3), "f4"), np.ones((2, 3), bool))

        return run

    def _output(self, name):
        def write(_, folder):
            if name in self.failing:
                raise self.failing[name]
            place = folder / ("flatten/picture.txt" if name == "flatten" else f"{name}.txt")
            place.parent.mkdir(exist_ok=True)
            place.write_text(name)

        return write


EVERYTHING = ["run.yaml", "flatten", "measurement", "sections", "figures", "summary", "report"]
ALL_FILES = {
    *("run.yaml.txt", "flatten/picture.txt", "measurement.txt", "sections.txt"),
    *("figures.txt", "summary.txt", "report.txt"),
}


@pytest.fixture
def workshop(tmp_path, monkeypatch):
    return Workshop(tmp_path, monkeypatch)


def test_the_first_visit_makes_everything(workshop):
    assert workshop.measure() == (["inputs", *COMPUTED], EVERYTHING)
    assert workshop.files() == ALL_FILES
    left = {path.name for path in workshop.run_folder.iterdir() if path.name.startswith(".")}
    assert not left


def test_the_second_visit_does_nothing_touches_nothing_and_loads_nothing(workshop):
    workshop.measure()
    ages = workshop.ages()
    assert workshop.measure() == ([], [])
    assert workshop.ages() == ages
    assert workshop.loaded == []


def test_a_changed_section_remakes_its_stage_and_what_shows_it(workshop):
    workshop.measure()
    ran, written = workshop.measure(strain={"window": 7})
    assert ran == ["strain"]
    assert written == ["run.yaml", "measurement", "sections", "figures", "summary", "report"]
    assert workshop.files() == ALL_FILES
    ran, _ = workshop.measure(match={"ratio": 0.7}, strain={"window": 7})
    assert ran == ["match", "morph", "correlate", "lift", "spread", "align", "strain"]


def test_a_changed_input_file_remakes_what_comes_from_it(workshop):
    workshop.measure()
    (workshop.folder / "b.obj").write_text("another")
    ran, written = workshop.measure()
    assert ran == ["inputs", *COMPUTED]
    assert written == [name for name in EVERYTHING if name != "run.yaml"]


def test_a_changed_picture_setting_runs_no_stage(workshop):
    workshop.measure()
    ran, written = workshop.measure(report={"figures": False})
    assert ran == []
    assert "figures" in written
    assert "flatten" not in written


@pytest.mark.parametrize("file", sorted(ALL_FILES))
def test_a_deleted_output_is_remade_alone(workshop, file):
    workshop.measure()
    (workshop.run_folder / file).unlink()
    ran, written = workshop.measure()
    assert ran == []
    assert len(written) == 1
    assert workshop.files() == ALL_FILES


def test_a_deleted_result_is_made_again(workshop):
    workshop.measure()
    (workshop.run_folder / "lift" / "result.npz").unlink()
    ran, _ = workshop.measure()
    assert ran == ["lift"]
    assert workshop.files() == ALL_FILES


def test_until_stops_there_and_the_rest_follows_later(workshop):
    ran, written = workshop.measure(until="match")
    assert ran == ["inputs", "flatten", "match"]
    assert written == ["run.yaml", "flatten"]
    ran, written = workshop.measure()
    assert ran == ["morph", "correlate", "lift", "spread", "align", "strain"]
    assert written == ["measurement", "sections", "figures", "summary", "report"]


def test_until_with_another_configuration_removes_what_no_longer_belongs(workshop):
    workshop.measure()
    workshop.measure(until="match", match={"ratio": 0.7})
    assert workshop.files() == {"run.yaml.txt", "flatten/picture.txt"}


def test_force_takes_along_what_depends_on_it(workshop):
    workshop.measure()
    ran, written = workshop.measure(force=["lift"])
    assert ran == ["lift", "spread", "align", "strain"]
    assert "measurement" in written
    assert "flatten" not in written


def test_a_stage_that_fails_leaves_no_outputs_of_an_earlier_run(workshop):
    workshop.measure()
    workshop.failing["match"] = StageError("nothing matched")
    with pytest.raises(StageError):
        workshop.measure(match={"ratio": 0.7})
    assert workshop.files() == {"run.yaml.txt", "flatten/picture.txt"}
    workshop.failing.clear()
    ran, _ = workshop.measure(match={"ratio": 0.7})
    assert ran == ["match", "morph", "correlate", "lift", "spread", "align", "strain"]
    assert workshop.files() == ALL_FILES


@pytest.mark.parametrize("existed", [True, False])
def test_bad_input_leaves_no_trace_in_a_new_folder(workshop, existed):
    if existed:
        workshop.run_folder.mkdir()
    workshop.failing["flatten"] = DataError("no pattern")
    with pytest.raises(DataError):
        workshop.measure()
    assert workshop.run_folder.exists() == existed
    assert not existed or not list(workshop.run_folder.iterdir())


def test_settings_refused_late_leave_no_trace_in_a_new_folder_and_all_in_an_old_one(workshop):
    workshop.failing["correlate"] = ConfigError("the region holds no pixel")
    with pytest.raises(ConfigError):
        workshop.measure()
    assert not workshop.run_folder.exists()
    workshop.failing.clear()
    workshop.measure()
    workshop.failing["correlate"] = ConfigError("the region holds no pixel")
    with pytest.raises(ConfigError):
        workshop.measure(correlate={"spacing": 9})
    workshop.failing.clear()
    assert workshop.measure(correlate={"spacing": 9})[0][0] == "correlate"


def test_a_full_disk_while_writing_an_output_keeps_the_stages(workshop):
    workshop.failing["measurement"] = OSError(errno.ENOSPC, "No space left on device")
    with pytest.raises(OSError, match="No space"):
        workshop.measure()
    assert workshop.files() == {"run.yaml.txt", "flatten/picture.txt"}
    assert not list(workshop.run_folder.glob(".partial*"))
    workshop.failing.clear()
    assert workshop.measure() == ([], ["measurement", "sections", "figures", "summary", "report"])


def test_a_run_killed_before_its_first_result_is_taken_up(workshop):
    workshop.run_folder.mkdir()
    (workshop.run_folder / ".partial-flatten").mkdir()
    (workshop.run_folder / ".partial-flatten" / "result.npz").touch()
    ran, _ = workshop.measure()
    assert ran == ["inputs", *COMPUTED]
    assert not (workshop.run_folder / ".partial-flatten").exists()


def test_somebodys_folder_is_left_alone(workshop):
    workshop.run_folder.mkdir()
    (workshop.run_folder / "thesis.tex").write_text("important")
    with pytest.raises(ConfigError, match="no run of shapemorph"):
        workshop.measure()
    assert [path.name for path in workshop.run_folder.iterdir()] == ["thesis.tex"]


def test_a_configuration_of_the_name_of_ours_is_left_alone(workshop):
    workshop.run_folder.mkdir()
    (workshop.run_folder / "run.yaml").write_text("# written by hand")
    with pytest.raises(ConfigError, match="no run of shapemorph"):
        workshop.measure()
    assert (workshop.run_folder / "run.yaml").read_text() == "# written by hand"


def test_files_that_are_not_ours_survive_in_a_run(workshop):
    workshop.measure()
    (workshop.run_folder / "notes.md").write_text("mine")
    workshop.measure(match={"ratio": 0.7})
    assert (workshop.run_folder / "notes.md").read_text() == "mine"


def test_a_missing_mesh_is_found_before_anything_is_made(workshop):
    (workshop.folder / "b.obj").unlink()
    with pytest.raises(DataError, match=r"b\.obj does not exist"):
        workshop.measure()
    assert not workshop.run_folder.exists()
