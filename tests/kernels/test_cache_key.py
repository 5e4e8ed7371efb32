"""An edited kernel never runs stale, whatever file the edit is in."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import shapemorph

INNER = """
from shapemorph.kernels.inner import inner

FACTOR = 3.0


@inner()
def scaled(x):
    return FACTOR * x
"""
OUTER = """
from numba import njit

from shapemorph.kernels.probe_inner import scaled


@njit(cache=True)
def outer(x):
    return scaled(x) + 1.0
"""
RUN = """
from shapemorph.kernels.probe import outer

print(outer(2.0), sum(outer.stats.cache_hits.values()))
"""


@pytest.fixture
def tree(tmp_path):
    """The part of the package that sets up the cache, and two kernels in two files."""
    source, copy = Path(shapemorph.__file__).parent, tmp_path / "shapemorph"
    for name in ("__init__.py", "core/__init__.py", "core/status.py", "core/arrays.py"):
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source / name, copy / name)
    kernels = copy / "kernels"
    kernels.mkdir()
    for name in ("__init__.py", "cache_files.py", "inner.py", "late_blas.py"):
        shutil.copy(source / "kernels" / name, kernels / name)
    (kernels / "probe_inner.py").write_text(INNER)
    (kernels / "probe.py").write_text(OUTER)
    return tmp_path


def _run(tree, place):
    known = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "PYTHONPATH")}
    environment = known | {"PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"} | place
    command = [sys.executable, "-c", RUN]
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env=environment, cwd=tree
    )
    assert done.returncode == 0, done.stderr
    value, hits = done.stdout.split()
    return float(value), int(hits)


def test_an_edited_callee_in_another_file_is_compiled_anew(tree):
    place = {"NUMBA_CACHE_DIR": str(tree / "cache")}
    assert _run(tree, place) == (7.0, 0)
    assert _run(tree, place) == (7.0, 1)  # without an edit nothing is compiled
    callee = tree / "shapemorph" / "kernels" / "probe_inner.py"
    callee.write_text(INNER.replace("3.0", "5.0"))
    assert _run(tree, place) == (11.0, 0)
