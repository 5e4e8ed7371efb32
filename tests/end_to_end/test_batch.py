"""A batch of small specimens, one of which cannot be read, through every kind of death."""

import csv
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from shapemorph.cli import main

pytest.importorskip("distributed", reason="Dask is not installed")
pytestmark = pytest.mark.slow
needs_proc = pytest.mark.skipif(not Path("/proc").is_dir(), reason="finds workers through /proc")

SMALL = ("faces=3000", "texture=512", "speckle=1.8", "vertex_noise=0.004")
GOOD = ("s1", "s2", "s3", "s4", "s5")


@pytest.fixture(scope="module")
def specimens(tmp_path_factory):
    """Folder with batch.yaml: five good pairs and one whose reference is no mesh."""
    folder = tmp_path_factory.mktemp("lab")
    for number, name in enumerate(GOOD):
        shape = ("rigid", "indentation")[number % 2]
        settings = [f"synthesize.{text}" for text in (*SMALL, f"seed={number}")]
        words = [word for text in settings for word in ("--set", text)]
        assert main(["synthesize", shape, "-o", str(folder / "scans" / name), *words]) == 0
    (folder / "scans" / "s6").mkdir()
    (folder / "scans" / "s6" / "reference.obj").write_text("no mesh")
    (folder / "scans" / "s6" / "deformed.obj").write_text("no mesh")
    (folder / "batch.yaml").write_text(
        'base: {report: {figures: false}}\nfolders: {pattern: "scans/*"}\n', encoding="utf-8"
    )
    return folder


def _start(folder, *words):
    command = [sys.executable, "-m", "shapemorph", "batch", "batch.yaml", "-o", "out", *words]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, cwd=folder, text=True, **pipes)


def _wait_for(process, text):
    for line in process.stderr:
        if text in line:
            return
    raise AssertionError(f"{text} was never said")


def _workers(process):
    """Process ids of the workers that a batch has started itself."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        try:
            parent = int(path.joinpath("stat").read_text().rpartition(")")[2].split()[1])
            command = path.joinpath("cmdline").read_bytes()
        except OSError:
            continue
        if parent == process.pid and b"spawn_main" in command:
            found.append(int(path.name))
    return found


def _rows(folder):
    with (folder / "out" / "batch.csv").open(newline="", encoding="utf-8") as stream:
        return {row["case"]: row for row in csv.DictReader(stream)}


@needs_proc
def test_kill_of_a_worker_and_of_the_parent_cost_nothing_that_was_finished(specimens):
    first = _start(specimens)
    _wait_for(first, "s1: begin")
    worker, *_ = _workers(first)
    os.kill(worker, signal.SIGKILL)
    _wait_for(first, "[2/6]")
    others = _workers(first)
    first.kill()
    first.communicate()
    finished = {name for name, row in _rows(specimens).items() if row["state"] == "done"}
    assert finished

    second = _start(specimens)
    _, said = second.communicate(timeout=300)
    rows = _rows(specimens)
    assert second.returncode == 1, said
    assert {name for name in rows if rows[name]["state"] in ("done", "kept")} == set(GOOD)
    assert finished <= {name for name in rows if rows[name]["state"] == "kept"}
    assert rows["s6"]["state"] == "failed"
    assert "reference.obj: expected an OBJ file with vertices" in rows["s6"]["reason"]
    assert all((specimens / "out" / rows[name]["report"]).is_file() for name in GOOD)
    assert not list((specimens / "out").rglob(".partial*"))
    assert not [pid for pid in others if Path(f"/proc/{pid}").exists()]


@needs_proc
def test_an_interrupt_ends_everything_with_one_line(specimens):
    process = _start(specimens, "--set", "match.ratio=0.84")
    _wait_for(process, "begin")
    workers = _workers(process)
    for pid in (*workers, process.pid):  # as a terminal does it
        os.kill(pid, signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted; finished stages are kept" in said
    assert "Traceback" not in said
    assert not [pid for pid in workers if Path(f"/proc/{pid}").exists()]


def test_a_scheduler_elsewhere_gives_the_same_files(specimens):
    from distributed import LocalCluster

    config = specimens / "two.yaml"
    config.write_text(
        'base: {report: {figures: false}}\nfolders: {pattern: "scans/s[12]"}\n', encoding="utf-8"
    )
    words = ["batch", str(config), "--quiet"]
    with LocalCluster(
        n_workers=1, threads_per_worker=2, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        address = cluster.scheduler_address
        assert main([*words, "-o", str(specimens / "far"), "--scheduler", address]) == 0
    assert main([*words, "-o", str(specimens / "near"), "--set", "cluster.workers=1"]) == 0
    for name in GOOD[:2]:
        near, far = (
            (specimens / side / "cases" / name / "measurement.csv").read_bytes()
            for side in ("near", "far")
        )
        assert near == far
