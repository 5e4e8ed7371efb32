"""One small measured pair for all tests of the whole path."""

from pathlib import Path

import pytest

from shapemorph.cli import main

DATA = Path(__file__).parents[2] / "data" / "synthetic" / "bulge"


@pytest.fixture(scope="session")
def pair():
    """Folder with reference.obj, deformed.obj and truth.npz."""
    return DATA


@pytest.fixture(scope="session")
def measured(pair, tmp_path_factory):
    """Folder of a finished run without figures; read only."""
    folder = tmp_path_factory.mktemp("measured") / "run"
    words = ["measure", str(pair / "reference.obj"), str(pair / "deformed.obj")]
    assert main([*words, "-o", str(folder), "--set", "report.figures=false", "--quiet"]) == 0
    return folder
