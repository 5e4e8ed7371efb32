"""The door: commands, exit codes, and what goes to which stream."""

import json
import os
import re
import subprocess
import sys
import time

import pytest

import shapemorph
from shapemorph.cli.main import app, main
from shapemorph.config import RunConfig
from shapemorph.core.errors import DataError, StageError
from shapemorph.io.config_files import read_config
from shapemorph.io.meshes import READERS
from shapemorph.pipeline.stagelist import STAGES

COMMANDS = {
    "calibrate",
    "reconstruct",
    "track",
    "reproduce",
    *("measure", "run", "flatten", "match", "morph", "correlate", "lift", "align", "strain"),
    *(
        "spread",
        "synthesize",
        "compare",
        "init",
        "check",
        "report",
        "doctor",
        "export",
        "batch",
        "noise",
        "assess",
    ),
}


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def _one_line(capsys):
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert captured.err.startswith("shapemorph: ")
    return captured.err


def test_exactly_the_commands_that_work_are_listed():
    listed = {name for name in app if not name.startswith("-")}
    assert listed == COMMANDS


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_every_command_explains_itself(command, capsys):
    assert main([command, "--help"]) == 0
    assert f"Usage: shapemorph {command}" in capsys.readouterr().out


def _words_of_help(command, capsys):
    main([command, "--help"])
    return set(re.findall(r"[a-z]+", capsys.readouterr().out.lower()))


def test_measure_names_every_format_that_is_read(capsys):
    formats = {suffix.removeprefix(".") for suffix in READERS}
    assert formats <= _words_of_help("measure", capsys)


def test_run_names_every_stage_that_it_can_stop_after(capsys):
    assert {stage.name for stage in STAGES} <= _words_of_help("run", capsys)


def test_the_version_is_that_of_the_package(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip() == shapemorph.__version__


def test_help_loads_nothing_heavy():
    code = "import sys; from shapemorph.cli import main; main(['--help']); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    heavy = {"numpy", "scipy", "numba", "cv2", "pyvista", "open3d", "trimesh", "igl", "pydantic"}
    assert not heavy & set(done.stdout.splitlines()[-1].split())


@pytest.mark.slow
def test_help_answers_within_half_a_second_of_processor_time():
    before, begin = os.times(), time.perf_counter()
    subprocess.run([sys.executable, "-m", "shapemorph", "--help"], capture_output=True, check=True)
    after = os.times()
    used = after.children_user + after.children_system
    used -= before.children_user + before.children_system
    assert used < 0.5
    assert time.perf_counter() - begin < 5.0


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["mesure", "a", "b"], 'Did you mean "measure"'),
        (["measure", "a"], "DEFORMED"),
        (["measure", "a", "b", "--fast"], "--fast"),
        (["run"], "CONFIG"),
        (["run", "absent.yaml"], "shapemorph init"),
        (["correlate", "a.png"], "two pictures"),
        (["measure", "a", "b", "--set", "strain.windw=5"], "did you mean strain.window?"),
        (["measure", "a", "b", "--set", "strain.window=wide"], "expected a whole number"),
        (["synthesize", "cube"], "expected a shape (dome, bulge, indentation, freeform, hole, "),
        (["report", "."], "run.yaml"),
        (["report", "absent"], "run directory absent was not found"),
        (["report", __file__], "expected the directory of a run, got the file"),
        (["run", __file__], "expected a YAML file (.yaml, .yml) or the directory of a run"),
        (["run", "absent"], "absent was not found: expected a YAML file"),
    ],
)
def test_usage_and_configuration_errors_are_one_line_and_exit_with_2(words, says, capsys, tmp_path):
    assert main(words) == 2
    assert says in _one_line(capsys)
    assert not list(tmp_path.iterdir())


def test_an_unknown_stage_is_refused_before_anything_is_read(capsys, tmp_path):
    (tmp_path / "a.yaml").write_text("inputs: {reference: a.obj, deformed: b.obj}\n")
    assert main(["run", "a.yaml", "--until", "corelate"]) == 2
    assert "correlate" in _one_line(capsys)


def test_init_writes_the_defaults_and_never_over_a_file(capsys, tmp_path):
    assert main(["init"]) == 0
    assert capsys.readouterr().out == "shapemorph.yaml\n"
    assert read_config(tmp_path / "shapemorph.yaml", RunConfig) == RunConfig()
    (tmp_path / "shapemorph.yaml").write_text("mine")
    assert main(["init"]) == 2
    assert "exists already" in _one_line(capsys)
    assert (tmp_path / "shapemorph.yaml").read_text() == "mine"


@pytest.mark.parametrize(
    ("error", "code", "says"),
    [
        (DataError("two\nlines"), 3, "two lines"),
        (StageError("nothing matched"), 4, "nothing matched"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (ZeroDivisionError("oops"), 1, "--debug"),
        (OSError(28, "No space left on device", "result.npz"), 1, "the disk is full"),
        (MemoryError(), 1, "out of memory"),
    ],
)
def test_whatever_happens_is_one_line_and_an_exit_code(error, code, says, capsys, monkeypatch):
    def fail(*_args, **_kwargs):
        raise error

    monkeypatch.setitem(main.__globals__, "app", fail)
    assert main(["measure", "a", "b"]) == code
    assert says in _one_line(capsys)


def test_debug_lets_the_traceback_through(monkeypatch):
    def fail(*_args, **_kwargs):
        raise ZeroDivisionError

    monkeypatch.setitem(main.__globals__, "app", fail)
    with pytest.raises(ZeroDivisionError):
        main(["doctor", "--debug"])


def test_doctor_names_the_command_that_mends(capsys, monkeypatch):
    from shapemorph.pipeline import doctor

    findings = [
        doctor.Finding("numpy", ok=True, detail="2"),
        doctor.Finding("libEGL.so.1", ok=False, detail="not found", remedy="apt-get install x"),
    ]
    monkeypatch.setattr(doctor, "examine", lambda: iter(findings))
    assert main(["doctor"]) == 1
    assert "mend it with: apt-get install x" in capsys.readouterr().out
    assert main(["doctor", "--json"]) == 1
    assert [entry["ok"] for entry in json.loads(capsys.readouterr().out)] == [True, False]
