"""A process that draws: what it answers, and what becomes of it when something fails."""

import io
import pickle
import subprocess
import sys
import time

import pytest

from shapemorph.core.errors import StageError
from shapemorph.view import shape_process
from shapemorph.view.shape_process import ShapeProcess


def _instead(monkeypatch, code):
    """Start a process that runs some lines in place of the drawing one."""
    start = subprocess.Popen
    monkeypatch.setattr(
        shape_process.subprocess,
        "Popen",
        lambda _, **options: start([sys.executable, "-c", code], **options),
    )


def test_a_process_that_dies_says_how_to_go_on_without_it(monkeypatch):
    _instead(monkeypatch, "import os; os.kill(os.getpid(), 9)")
    with ShapeProcess() as process:
        process.begin("shapes")
        with pytest.raises(StageError, match=r"code -9.*doctor.*report\.figures"):
            process.finish()


def test_what_the_process_refuses_is_raised_here(monkeypatch):
    _instead(
        monkeypatch,
        "import sys, pickle; from shapemorph.core.errors import StageError;"
        "pickle.load(sys.stdin.buffer); pickle.dump(StageError('no screen'), sys.stdout.buffer)",
    )
    with ShapeProcess() as process:
        process.begin("shapes")
        with pytest.raises(StageError, match="no screen"):
            process.finish()


def test_a_run_that_fails_leaves_no_process_behind(monkeypatch):
    _instead(monkeypatch, "import time; time.sleep(60)")
    begin = time.perf_counter()
    with ShapeProcess() as process:
        process.begin(bytes(1 << 20))  # more than a pipe holds
    assert process._process.returncode is not None
    assert time.perf_counter() - begin < 30


def test_python_that_cannot_be_started_is_one_clear_line(monkeypatch):
    monkeypatch.setattr(shape_process.sys, "executable", "/nowhere/python")
    with pytest.raises(StageError, match="could not start Python"):
        ShapeProcess()


@pytest.mark.parametrize("sent", [b"", pickle.dumps(list(range(1000)))[:100]])
def test_a_run_that_ends_early_ends_the_drawing_quietly(monkeypatch, sent):
    class NoScene:
        def __enter__(self):
            return self

        def __exit__(self, *_):
            return None

    monkeypatch.setattr("shapemorph.view.render.Scene", NoScene)
    answer = io.BytesIO()
    shape_process._main(io.BytesIO(sent), answer)
    assert answer.getvalue() == b""
