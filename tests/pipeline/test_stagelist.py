"""One word in six places, and regions brought to the grid."""

import importlib.util

import numpy as np
import pytest

from shapemorph.cli.main import app
from shapemorph.config import RunConfig
from shapemorph.core.grid import CorrelationGrid
from shapemorph.pipeline.stagelist import COMPUTED, SOURCES, STAGES, sample_at_grid, sections


def test_every_stage_reads_sources_and_earlier_stages_only():
    known = set(SOURCES)
    for stage in STAGES:
        assert known.issuperset(stage.reads)
        known.add(stage.name)


def test_the_spread_of_laws_does_nothing_unless_further_laws_are_listed():
    assert sections(RunConfig())["spread"] is None
    several = sections(RunConfig(morph={"laws": ["identity"]}))["spread"]
    assert several.morph.all_laws == ("warp", "identity")


@pytest.mark.parametrize("name", [name for name in COMPUTED if name != "spread"])
def test_a_stage_is_section_module_and_command(name):
    assert name in RunConfig.model_fields
    assert importlib.util.find_spec(f"shapemorph.stages.{name}")
    assert name in list(app)
    assert sections(RunConfig())[name] is getattr(RunConfig(), name)


def test_a_mask_is_looked_up_at_the_grid_points_as_column_and_row():
    mask = np.zeros((20, 30), bool)
    mask[4, 25] = True
    rows, columns = np.mgrid[0:25:4, 1:35:4].astype(float)
    shape = rows.shape
    place = np.stack([columns, rows], axis=-1)
    grid = CorrelationGrid(
        place,
        place.copy(),
        np.zeros((*shape, 2, 2)),
        np.ones(shape),
        np.ones(shape, int),
        np.ones((*shape, 2)),
        np.zeros(shape, "u1"),
        4,
        21,
        0.0,
    )
    found = sample_at_grid(mask, grid)
    assert found.shape == shape
    assert place[found].tolist() == [[25.0, 4.0]]
