"""The small case in data/synthetic and the configurations that make and measure it."""

from pathlib import Path

import pytest

from shapemorph.config import RunConfig
from shapemorph.io.config_files import read_config
from shapemorph.pipeline.synthesize import SynthesizeFile, write_case

ROOT = Path(__file__).parents[2]
CASE = ROOT / "data" / "synthetic" / "bulge"


def test_the_case_is_reproduced_byte_for_byte(tmp_path):
    document = read_config(ROOT / "configs" / "demo_case.yaml", SynthesizeFile, [])
    files = write_case(document.synthesize, tmp_path)
    assert sorted(file.name for file in files) == sorted(file.name for file in CASE.iterdir())
    for file in files:
        same = file.read_bytes() == (CASE / file.name).read_bytes()
        assert same, file.name  # not compared here: pytest would diff megabytes for an hour


def test_the_case_is_small():
    assert sum(file.stat().st_size for file in CASE.iterdir()) < 3_000_000


@pytest.mark.parametrize("side", ["reference", "deformed"])
def test_the_demo_measures_this_case(side):
    document = read_config(ROOT / "configs" / "demo.yaml", RunConfig, [])
    assert getattr(document.inputs, side).resolve() == (CASE / f"{side}.obj").resolve()
