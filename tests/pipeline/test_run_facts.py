"""What is said of seconds and versions."""

import subprocess
import sys
from importlib import metadata
from types import SimpleNamespace

from shapemorph.pipeline.run_facts import run_figures, versions


def test_versions_name_what_draws_and_aligns_without_loading_it():
    code = (
        "import sys; from shapemorph.pipeline.run_facts import versions; print(*versions());"
        "print(*{'open3d', 'pyvista', 'vtk', 'vtkmodules'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    named, loaded = done.stdout.split("\n")[:2]
    assert {"numpy", "numba", "open3d", "pyvista", "vtk"} <= set(named.split())
    assert loaded == ""


def test_a_package_under_another_distribution_or_none_does_not_cost_the_summary(monkeypatch):
    def distribution(name):
        if name in ("open3d", "libigl"):
            raise metadata.PackageNotFoundError(name)
        version = {"open3d-cpu": "0.99"}.get(name, "1.0")
        text = f"Metadata-Version: 2.4\nName: {name}\nVersion: {version}\n\nVersion: 7\n"
        return SimpleNamespace(read_text=lambda _: text)

    monkeypatch.setattr(metadata, "distribution", distribution)
    found = versions()
    assert found["open3d"] == "0.99"
    assert found["vtk"] == "1.0"
    assert "libigl" not in found


def test_the_total_means_the_same_before_and_after_the_summary_was_timed():
    first = {"flatten": 2.0, "write figures": 3.0}
    later = {**first, "write summary": 0.25, "write report": 0.5}
    assert run_figures(first)["seconds"] == {**first, "total": 5.0}
    assert run_figures(later)["seconds"] == {**later, "total": 5.0}


def test_versions_are_those_of_the_metadata():
    found = versions()
    assert found["numpy"] == metadata.version("numpy")
    assert found["numba"] == metadata.version("numba")
