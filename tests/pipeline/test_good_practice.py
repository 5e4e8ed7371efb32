import pytest

from shapemorph.config import RunConfig
from shapemorph.io.noise_files import QUANTITIES
from shapemorph.pipeline.good_practice import NOT_PROVIDED, good_practice


def _spread(low, median, high):
    return {"p1": low, "median": median, "p99": high}


def _side(scale):
    return {
        "method": "bff", "px_per_mm": scale, "texels_per_px": 1.5, "flips": 0,
        "local_px_per_mm": _spread(scale / 2, scale, 2 * scale), "anisotropy": _spread(1, 1.1, 1.2),
    }  # fmt: skip


@pytest.fixture
def sections():
    return {
        "flatten": {"reference": _side(10.0), "deformed": _side(8.0)},
        "match": {"counts": {"matched": 90, "kept": 80}, "manner": "features", "residual_px": 0.25},
        "correlate": {
            "grey_noise": 0.0125, "speckle_px": 5.0, "subset_size_px": 21, "spacing_px": 5,
            "order": 1, "zncc": _spread(0.9, 0.95, 0.99),
        },
        "strain": {
            "window_points": 5, "gauge_px": 41.0, "gauge_mm": 4.1,
            "sigma_E1": {"median": 0.001}, "sigma_E2": {"median": 0.002},
        },
        "sigma_displacement_mm": {"median": 0.006},
        "points": {
            "ok": 90, "total": 100, "ok_share": 0.9,
            "statuses": {"OK": 90, "OUTSIDE_MASK": 50, "OUTLIER": 10},
        },
        "align": {"method": "points", "rms_mm": 0.007},
        "versions": {"shapemorph": "9.9"},
    }  # fmt: skip


def test_what_only_the_user_knows_is_asked_for(sections):
    tables = good_practice(sections, RunConfig(), None)
    assert tables["hardware"]["camera or scanner"] == NOT_PROVIDED
    assert tables["analysis"]["displacement noise floor and bias"].startswith(NOT_PROVIDED)


def test_the_words_of_the_user_stand_in_the_table(sections):
    equipment = {"camera": "Baumer TXG50", "exposure": 10, "stand_off": "400 mm"}
    config = RunConfig.model_validate({"report": {"equipment": equipment}})
    hardware = good_practice(sections, config, None)["hardware"]
    assert hardware["camera or scanner"] == "Baumer TXG50"
    assert hardware["exposure"] == "10"
    assert hardware["stand-off distance"] == "400 mm"


@pytest.mark.parametrize(("name", "word"), [("cubic", "bicubic"), ("quintic", "biquintic")])
def test_the_interpolant_is_the_one_in_use(sections, name, word):
    config = RunConfig.model_validate({"correlate": {"interpolation": name}})
    analysis = good_practice(sections, config, None)["analysis"]
    assert analysis["interpolant"] == f"{word} B-spline with exact prefilter"


def test_lengths_are_in_mm_where_the_scale_varies(sections):
    analysis = good_practice(sections, RunConfig(), None)["analysis"]
    assert analysis["subset size"].startswith("21 px; 1.05 / 2.1 / 4.2 mm")
    assert analysis["step"].startswith("5 px; 0.25 / 0.5 / 1 mm")
    assert analysis["virtual strain gauge"] == "41 px, 4.1 mm"


def test_noise_floor_and_bias_are_those_measured(sections):
    noise = {name: {"mean": 0.001 * k, "std": 0.01 * k} for k, name in enumerate(QUANTITIES)}
    analysis = good_practice(sections, RunConfig(), noise)["analysis"]
    assert "v: 0.01 mm, bias 0.001 mm" in analysis["displacement noise floor and bias"]
    assert "E2: 0.04, bias 0.004" in analysis["strain noise floor and bias"]


def test_losses_name_their_reasons(sections):
    rows = good_practice(sections, RunConfig(), None)["flattening and matching"]
    assert rows["points with a value"] == "90 of 100 (90.0%)"
    assert rows["points lost"] == "OUTLIER 10"
    assert rows["local scale"] == "reference 5 / 10 / 20 px/mm, deformed 4 / 8 / 16 px/mm"
