"""The paper as one command, small: a page with every method against the truth."""

import csv
import json

import numpy as np
import pytest

from shapemorph.config import ReproduceConfig
from shapemorph.io.images import read_grey_image
from shapemorph.pipeline.reproduce import reproduce_membrane
from shapemorph.view.pages import mean_and_spread

SMALL = ReproduceConfig.model_validate(
    {
        "twin": {
            "law": "analytic",
            "scale": 0.2,
            "steps": 1,
            "travel": 6.0,
            "rings": 16,
            "views": 0,
        },
        "spacing": 8,
        "noises": [],
        "states": 0,
        "paper": False,
    }
)


@pytest.mark.slow
def test_the_page_shows_what_the_summary_holds(tmp_path):
    summary = reproduce_membrane(SMALL, tmp_path / "page", listener=lambda _: None)
    folder = tmp_path / "page"
    assert json.loads((folder / "summary.json").read_text())["kind"] == "membrane"
    page = (folder / "index.html").read_text(encoding="utf-8")
    for name, method in summary["methods"].items():
        errors = method["against_truth_mm"]
        assert errors["w"]["sum"] < 0.15, name
        assert mean_and_spread(errors["u"]) in page
    assert set(summary["methods"]) == {"incremental", "image_morphing", "shape_morphing"}
    with (folder / "errors.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 3 * 5 + 2 * 3
    figures = sorted(path.stem for path in (folder / "figures").glob("*.png"))
    assert figures[:4] == ["01_stereo_pairs", "02_stages", "03_gradients", "05_fields"]
    assert figures[4:8] == ["06_calibrated", "07_profiles", "08_errors", "10_zncc"]
    assert figures[8:] == ["11_first_guesses", "12_p_against_p0"]
    assert summary["settings_by_case"]["incremental"]["subset_px"] == 21
    assert "IC-GN to 0.001 px" in page
    for path in (folder / "figures").glob("*.png"):
        assert np.ptp(read_grey_image(path).grey) > 0.3
