"""Limits of the methods: direct correlation of the ends, and the settings side by side."""

import shutil

import numpy as np
import pytest

from shapemorph.config import ReproduceConfig
from shapemorph.io.images import read_grey_image, write_grey_png
from shapemorph.io.twin_files import read_twin
from shapemorph.pipeline.reproduce_limits import direct_correlation, settings_by_case
from shapemorph.pipeline.twin import write_twin_case

CONFIG = ReproduceConfig.model_validate(
    {
        "twin": {
            "law": "analytic",
            "scale": 0.2,
            "steps": 8,
            "travel": 28.0,
            "rings": 16,
            "views": 0,
        },
        "spacing": 8,
    }
)


@pytest.fixture(scope="module")
def twin(tmp_path_factory):
    folder = tmp_path_factory.mktemp("direct") / "twin"
    write_twin_case(CONFIG.twin, folder, listener=lambda _: None)
    return folder


def test_direct_correlation_errs_more_the_farther_the_sheet_is_stretched(twin):
    truth = read_twin(twin / "truth.npz")
    near, far = (direct_correlation(CONFIG, truth, twin, state) for state in (1, 8))
    assert near.method == far.method == "direct"
    assert 1.0 < near.at < 1.15
    assert far.at > 1.5
    assert min(near.share, far.share) > 0.95
    assert near.error < far.error < 0.05  # a pixel shows 0.25 mm


def test_direct_correlation_finds_nothing_where_nothing_is_alike(twin, tmp_path):
    for path in twin.glob("*.*"):
        shutil.copyfile(path, tmp_path / path.name)
    shape = read_grey_image(tmp_path / "left_08.png").shape
    noise = np.random.default_rng(0).random(shape).astype(np.float32)
    write_grey_png(tmp_path / "left_08.png", noise, np.ones(shape, dtype=bool))
    found = direct_correlation(CONFIG, read_twin(twin / "truth.npz"), tmp_path, 8)
    assert found.share == 0.0
    assert np.isnan(found.error)


def test_settings_of_the_paper_stand_beside_ours(tmp_path):
    table = settings_by_case(CONFIG, tmp_path)
    assert table["paper_image_morphing"] == {
        "criterion": "NCC",
        "solver": "SQP to 0.1 px",
        "shape_function": 1,
        "subset_px": 21,
        "spacing_px": 8,
        "search_px": 41,
        "match_ratio": 0.816,
        "synthetic_images": 6,
    }
    assert table["image_morphing"]["criterion"] == "ZNSSD"
    assert table["incremental"]["synthetic_images"] is None
    assert list(table)[:3] == ["incremental", "image_morphing", "shape_morphing"]
