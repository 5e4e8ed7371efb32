"""A stored result is whole or absent, whatever happens while it is written."""

import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from shapemorph.core.errors import ConfigError, DataError
from shapemorph.core.image import GreyImage
from shapemorph.io.safe_files import (
    check_writable,
    move_files,
    scratch_folder,
    whole_file,
    whole_folder,
    write_json,
)
from shapemorph.io.store import RunStore


def _noun(value=0.5, size=4):
    return GreyImage(np.full((size, size + 1), value, "f4"), np.ones((size, size + 1), bool))


def test_what_is_saved_is_loaded_with_its_fingerprint(tmp_path):
    store = RunStore(tmp_path / "run")
    assert store.fingerprint("match") is None
    store.save("match", _noun(0.25), fingerprint="abc", seconds=1.5)
    assert store.fingerprint("match") == "abc"
    assert store.seconds("match") == 1.5
    assert store.load("match").grey[0, 0] == 0.25
    names = sorted(path.name for path in (tmp_path / "run" / "match").iterdir())
    assert names == ["result.json", "result.npz"]


def test_saving_again_replaces_everything_in_the_folder(tmp_path):
    store = RunStore(tmp_path)
    store.save("flatten", _noun(), fingerprint="old", seconds=0)
    (tmp_path / "flatten" / "reference.png").write_text("of the old result")
    store.save("flatten", _noun(), fingerprint="new", seconds=0)
    assert store.fingerprint("flatten") == "new"
    assert not (tmp_path / "flatten" / "reference.png").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["flatten"]


def test_a_failed_save_leaves_the_old_result_and_nothing_else(tmp_path, monkeypatch):
    store = RunStore(tmp_path)
    store.save("match", _noun(0.25), fingerprint="old", seconds=0)

    def full(*_args, **_kwargs):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match="No space"):
        store.save("match", _noun(), fingerprint="new", seconds=0)
    assert store.fingerprint("match") == "old"
    assert store.load("match").grey[0, 0] == 0.25
    assert [path.name for path in tmp_path.iterdir()] == ["match"]


@pytest.mark.parametrize("damage", ["shorter", "no json", "no npz", "broken json"])
def test_a_damaged_result_counts_as_absent(tmp_path, damage):
    store = RunStore(tmp_path)
    store.save("match", _noun(), fingerprint="abc", seconds=0)
    archive, header = tmp_path / "match" / "result.npz", tmp_path / "match" / "result.json"
    if damage == "shorter":
        archive.write_bytes(archive.read_bytes()[:-20])
    elif damage == "broken json":
        header.write_text(header.read_text()[:-20])
    else:
        (header if damage == "no json" else archive).unlink()
    assert store.fingerprint("match") is None
    with pytest.raises(DataError, match="no result of match"):
        store.load("match")


def test_an_archive_with_wrong_content_says_how_to_make_it_again(tmp_path):
    store = RunStore(tmp_path)
    store.save("match", _noun(), fingerprint="abc", seconds=0)
    archive = tmp_path / "match" / "result.npz"
    archive.write_bytes(bytes(len(archive.read_bytes())))
    with pytest.raises(DataError, match="--force match"):
        store.load("match")


def test_a_result_with_pickled_objects_is_not_loaded(tmp_path):
    store = RunStore(tmp_path)
    store.save("match", _noun(), fingerprint="abc", seconds=0)
    archive, header = tmp_path / "match" / "result.npz", tmp_path / "match" / "result.json"
    np.savez(archive, grey=np.array([{"a": 1}], dtype=object), mask=np.ones((1, 1), bool))
    content = json.loads(header.read_text())
    header.write_text(json.dumps({**content, "archive_bytes": archive.stat().st_size}))
    with pytest.raises(DataError, match="allow_pickle"):
        store.load("match")


KILLED = """
import sys
from pathlib import Path
import numpy as np
from shapemorph.core.image import GreyImage
from shapemorph.io.store import RunStore
store = RunStore(Path(sys.argv[1]))
print("ready", flush=True)
for number in range(10_000):
    value = np.full((700, 900), number, "f4")
    store.save("match", GreyImage(value, value >= 0), fingerprint=str(number), seconds=0.0)
"""


@pytest.mark.parametrize("delay", [0.02, 0.11, 0.23])
def test_a_killed_run_leaves_no_half_result(tmp_path, delay):
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "ready\n"
    time.sleep(delay)
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    store = RunStore(tmp_path)
    store.sweep()
    assert {path.name for path in tmp_path.iterdir()} <= {"match"}
    mark = store.fingerprint("match")
    if mark is not None:
        assert (store.load("match").grey == float(mark)).all()


def test_whole_file_appears_only_when_the_block_succeeds(tmp_path):
    target = tmp_path / "a.txt"
    target.write_text("old")
    with pytest.raises(FileNotFoundError), whole_file(target) as partial:
        partial.write_text((tmp_path / "absent").read_text())
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


def test_whole_folder_is_never_a_mixture(tmp_path):
    target = tmp_path / "stage"
    target.mkdir()
    (target / "old").touch()
    with whole_folder(target) as partial:
        (partial / "new").touch()
        assert [path.name for path in target.iterdir()] == ["old"]
    assert [path.name for path in target.iterdir()] == ["new"]


def test_a_scratch_folder_takes_an_unused_home_along(tmp_path):
    with scratch_folder(tmp_path / "new" / "home") as scratch:
        (scratch / "file").touch()
    assert not (tmp_path / "new" / "home").exists()
    with scratch_folder(tmp_path / "home") as scratch:
        (scratch / "deep").mkdir()
        (scratch / "deep" / "file").touch()
        moved = move_files(scratch, tmp_path / "home")
    assert moved == [tmp_path / "home" / "deep" / "file"]
    assert [path.name for path in (tmp_path / "home").iterdir()] == ["deep"]


def test_what_was_read_is_never_written_over(tmp_path):
    (tmp_path / "scan.png").write_text("mine")
    (tmp_path / "link").symlink_to(tmp_path)
    with scratch_folder(tmp_path) as scratch:
        (scratch / "a.vti").touch()
        (scratch / "scan.png").touch()
        with pytest.raises(ConfigError, match=r"scan\.png would be written over"):
            move_files(scratch, tmp_path, [tmp_path / "link" / "scan.png"])
    assert (tmp_path / "scan.png").read_text() == "mine"
    assert not (tmp_path / "a.vti").exists()


def test_json_has_null_where_there_is_no_number(tmp_path):
    write_json(tmp_path / "a.json", {"a": float("nan"), "b": [float("inf"), 1], "c": (2.5,)})
    assert json.loads((tmp_path / "a.json").read_text()) == {"a": None, "b": [None, 1], "c": [2.5]}


def test_an_output_below_a_file_is_refused_before_any_work(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match="is a file"):
        check_writable(tmp_path / "file" / "run")


def test_an_output_that_cannot_be_made_is_refused_before_any_work():
    with pytest.raises(ConfigError, match="cannot write"):
        check_writable(Path("/proc/shapemorph/run"))


def test_checking_leaves_nothing_behind(tmp_path):
    check_writable(tmp_path / "deep" / "down")
    assert not list(tmp_path.iterdir())
