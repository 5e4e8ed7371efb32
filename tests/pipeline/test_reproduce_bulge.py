"""The bulge as one command, small: photographs all around to strain, two laws, one page."""

import csv
import json

import numpy as np
import pytest

from shapemorph.config import BulgeConfig
from shapemorph.io.images import read_grey_image
from shapemorph.pipeline.reproduce_bulge import reproduce_bulge

SMALL = BulgeConfig.model_validate(
    {
        "twin": {"scale": 0.2, "frames": 18, "rings": 12, "samples": 1},
        "patches": 6,
        "spacing": 5,
        "subset_size": 19,
        "noises": [],
    }
)


@pytest.mark.slow
def test_the_page_shows_what_the_summary_holds(tmp_path):
    folder = tmp_path / "page"
    summary = reproduce_bulge(SMALL, folder, listener=lambda _: None)
    assert json.loads((folder / "summary.json").read_text())["kind"] == "bulge"
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert set(summary["laws"]) == {"fe", "landmarks"}
    for law in summary["laws"].values():
        rms = law["rms_away_from_kink"]
        assert law["points"] > 700
        assert rms["position_mm"] < 0.1  # a pixel shows 0.25 mm
        assert rms["E1"] < 0.08
        assert f"{rms['E1']:.4f}" in page
    assert summary["laws_agree_mm"] < 0.02
    with (folder / "errors.csv").open(encoding="utf-8") as stream:
        assert len(list(csv.DictReader(stream))) == 2 * 5
    named = ["11_calibrated", "13_points", "14_fields", "15_profiles"]
    for name in (*named, "17_stretch", "18_first_guesses", "19_p_against_p0"):
        assert np.ptp(read_grey_image(folder / "figures" / f"{name}.png").grey) > 0.3
    assert (folder / "morph" / "sequence.gif").is_file()


def test_another_experiment_is_refused():
    with pytest.raises(ValueError, match=r"expected twin\.kind bulge with frames"):
        BulgeConfig.model_validate({"twin": {"kind": "membrane"}})


def test_the_turn_holds_pairs_20_degrees_apart_evenly_all_around():
    for given in (BulgeConfig(), BulgeConfig.model_validate({"twin": {"scale": 0.5}})):
        assert given.twin.frames % (360 / 20) == 0
        assert given.twin.frames % given.patches == 0
    assert BulgeConfig.model_validate({"twin": {"frames": 360}}).twin.frames == 360
