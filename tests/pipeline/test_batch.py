"""The order of a batch, with a cluster that runs everything at once in this process."""

import contextlib
import csv
import json
import re

import pytest

from shapemorph.config import BatchConfig
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.io.batch_files import Case
from shapemorph.io.folder_lock import alone_in
from shapemorph.pipeline import batch, batch_case
from shapemorph.pipeline import measure as order
from shapemorph.pipeline.batch import run_batch
from shapemorph.pipeline.cluster import Crew
from shapemorph.pipeline.measure import Outcome

CREW = Crew("", 2, 1, 4e9, 2)


class KilledWorker(Exception):  # noqa: N818 - the name that Dask gives it
    """As Dask raises it."""


class Here:
    """A cluster of nobody."""

    crew = CREW

    def run(self, work, payloads, listener):
        for name, payload in payloads.items():
            listener({"case": name, "step": "begin", "state": "started"})
            try:
                yield name, work({**payload, "topic": "none"})
            except KilledWorker as error:
                yield name, error


@pytest.fixture
def lab(tmp_path, monkeypatch):
    """Folder of a batch where measuring writes a summary, or fails as told."""
    failing = {}
    measured = []

    def measure(config, folder, *, listener):  # noqa: ARG001
        measured.append((folder.name, config))
        error = failing.get(folder.name)
        if error:
            raise error
        if (folder / "summary.json").is_file():
            return Outcome(folder, (), ("flatten",), ())
        folder.mkdir(parents=True)
        verdict = {"level": "WARN", "reasons": ["WARN: few points"]}
        summary = {"verdict": verdict, "scorecard": {"E1 median": 0.25}}
        summary["seconds"] = {"flatten": 41.5, "total": 41.5}
        (folder / "summary.json").write_text(json.dumps(summary))
        return Outcome(folder, ("flatten",), (), ("summary",))

    monkeypatch.setattr(order, "measure", measure)
    monkeypatch.setattr(batch_case, "limit_threads", lambda _: None)
    monkeypatch.setattr(batch_case, "tell", lambda *_: None)
    monkeypatch.setattr(batch, "_cluster", lambda *_: contextlib.nullcontext(Here()))

    def run(*names, settings=(), **documents):
        cases = [Case(name, documents.get(name, {})) for name in names]
        events = []
        config = BatchConfig.model_validate({"cases": [{}]})
        outcome = run_batch(
            config, cases, tmp_path / "out", settings=settings, listener=events.append
        )
        return outcome, events

    run.failing, run.measured, run.folder = failing, measured, tmp_path / "out"
    return run


def _table(folder):
    with (folder / "batch.csv").open(newline="", encoding="utf-8") as stream:
        return {row["case"]: row for row in csv.DictReader(stream)}


def test_every_case_has_a_row_a_link_and_its_own_folder(lab):
    outcome, events = lab("a", "b", "c")
    assert [row["state"] for row in outcome.rows] == ["done"] * 3
    table = _table(lab.folder)
    assert table["b"]["reason"] == "few points"
    assert table["b"]["E1 median"] == "0.25"
    links = re.findall(r'href="(cases[^"]+)"', (lab.folder / "index.html").read_text())
    assert links == [f"cases/{name}/report.html" for name in "abc"]
    assert [event.text for event in events[:3]] == [str(CREW), "begin", "WARN"]
    assert [event.ended for event in events if event.state == "ended"] == [1, 2, 3]


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (DataError("a.obj: expected vertices,\n got none"), "a.obj: expected vertices, got none"),
        (ZeroDivisionError("by zero"), "unexpected ZeroDivisionError: by zero"),
        (MemoryError(), "out of memory"),
    ],
)
def test_a_case_that_fails_is_a_row_with_its_reason_and_the_others_go_on(lab, error, reason):
    lab.failing["b"] = error
    outcome, _ = lab("a", "b", "c")
    assert [row["state"] for row in outcome.rows] == ["done", "failed", "done"]
    assert _table(lab.folder)["b"]["reason"].startswith(reason)
    assert _table(lab.folder)["b"]["report"] == ""


def test_a_worker_that_died_again_and_again_is_a_row_too(lab, monkeypatch):
    def dies(payload):
        raise KilledWorker(payload["name"])

    monkeypatch.setattr(batch, "run_case", dies)
    outcome, _ = lab("a")
    assert "its worker died" in outcome.rows[0]["reason"]


def test_a_wrong_configuration_of_one_case_is_a_row_and_runs_nothing(lab):
    outcome, _ = lab("a", "b", a={"strain": {"windw": 5}})
    assert "unknown key strain.windw; did you mean strain.window" in outcome.rows[0]["reason"]
    assert "configuration of a" in outcome.rows[0]["reason"]
    assert [name for name, _ in lab.measured] == ["b"]


def test_the_next_time_finished_cases_are_kept_and_failed_ones_tried_again(lab):
    lab.failing["b"] = DataError("not yet")
    lab("a", "b")
    lab.failing.clear()
    outcome, _ = lab("a", "b")
    assert [row["state"] for row in outcome.rows] == ["kept", "done"]
    seconds = [float(_table(lab.folder)[name]["seconds"]) for name in ("a", "b")]
    assert seconds[0] == 41.5  # of the run that made it
    assert seconds[1] < 41.5


def test_settings_go_over_every_case_and_wrong_ones_are_refused_at_once(lab):
    lab("a", "b", settings=["strain.window=9"], a={"strain": {"window": 3}})
    assert [config.strain.window for _, config in lab.measured] == [9, 9]
    with pytest.raises(ConfigError, match=r"unknown key strain\.windw"):
        lab("a", settings=["strain.windw=9"])


def test_the_table_shows_all_cases_while_the_batch_goes_on(lab):
    seen = []
    lab.failing["c"] = DataError("last")

    def look(event):
        if event.state == "step" and event.case == "c":
            seen.append({name: row["state"] for name, row in _table(lab.folder).items()})

    config = BatchConfig.model_validate({"cases": [{}]})
    run_batch(config, [Case(name, {}) for name in "abc"], lab.folder, listener=look)
    assert seen == [{"a": "done", "b": "done", "c": "waiting"}]


def test_somebodys_folder_is_left_alone(lab):
    lab.folder.mkdir()
    (lab.folder / "thesis.tex").write_text("important")
    with pytest.raises(ConfigError, match="no batch of shapemorph"):
        lab("a")
    assert [path.name for path in lab.folder.iterdir()] == ["thesis.tex"]


def test_two_batches_do_not_work_in_one_folder(lab):
    with alone_in(lab.folder), pytest.raises(ConfigError, match="another batch works in it"):
        lab("a")
    assert lab("a")[0].rows[0]["state"] == "done"
