"""A process that draws: what it answers, and what becomes of it when something fails."""

import io
import pickle
import subprocess
import sys
import time

import pytest

from shapemorph.core.errors import StageError
from shapemorph.view import drawing_process, figures
from shapemorph.view.drawing_process import DrawingProcess


def _instead(monkeypatch, code):
    """Start a process that runs some lines in place of the drawing one."""
    start = subprocess.Popen
    monkeypatch.setattr(
        drawing_process.subprocess,
        "Popen",
        lambda _, **options: start([sys.executable, "-c", code], **options),
    )


def test_a_process_that_dies_says_how_to_go_on_without_it(monkeypatch):
    _instead(monkeypatch, "import os; os.kill(os.getpid(), 9)")
    with DrawingProcess() as process:
        process.draw(list, "nouns")
        with pytest.raises(StageError, match=r"code -9.*doctor.*report\.figures"):
            process.finish()


def test_what_the_process_refuses_is_raised_here(monkeypatch):
    _instead(
        monkeypatch,
        "import sys, pickle; from shapemorph.core.errors import StageError;"
        "pickle.load(sys.stdin.buffer); pickle.dump(StageError('no screen'), sys.stdout.buffer)",
    )
    with DrawingProcess() as process:
        process.draw(list, "nouns")
        with pytest.raises(StageError, match="no screen"):
            process.finish()


def test_a_run_that_fails_leaves_no_process_behind(monkeypatch):
    _instead(monkeypatch, "import time; time.sleep(60)")
    begin = time.perf_counter()
    with DrawingProcess() as process:
        process.draw(list, bytes(1 << 20))  # more than a pipe holds
    assert process._process.returncode is not None
    assert time.perf_counter() - begin < 30


def test_python_that_cannot_be_started_is_one_clear_line(monkeypatch):
    monkeypatch.setattr(drawing_process.sys, "executable", "/nowhere/python")
    with pytest.raises(StageError, match="could not start Python"):
        DrawingProcess()


class _NoScene:
    def __init__(self, pixel_ratio):
        assert pixel_ratio == 1

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None


def test_a_run_that_ends_while_it_asks_ends_the_drawing_quietly(monkeypatch):
    monkeypatch.setattr("shapemorph.view.render.Scene", _NoScene)
    answer = io.BytesIO()
    drawing_process._main(io.BytesIO(pickle.dumps(list(range(1000)))[:100]), answer, "light")
    assert answer.getvalue() == b""


def test_figures_come_in_the_order_in_which_they_are_asked_for(results):
    with DrawingProcess() as process:
        process.draw(figures.histogram_figures, results.measurement)
        process.draw(figures.flattening_figures, results.pair)
        assert [name for name, _ in process.finish()] == ["histograms", "flattening"]
