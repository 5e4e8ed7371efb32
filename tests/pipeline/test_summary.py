"""Figures of a run, on a sheet whose areas are known, and the verdict on them."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from shapemorph.core.flattened import Distortion, FlattenedPair, FlattenedSurface
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import CalibratedImage, Chart, GreyImage
from shapemorph.core.measurement import Measurement
from shapemorph.core.results import RunResults
from shapemorph.core.status import PointStatus
from shapemorph.core.surface import TrackedSurface
from shapemorph.pipeline.summary import (
    measured_share,
    point_figures,
    spread,
)
from shapemorph.pipeline.verdict import judge

HEIGHT, WIDTH, SPACING = 60, 90, 5


def _surface():
    """Two triangles side by side: 4 px/mm left of x = 45, 2 x 3 px/mm right of it."""
    triangle = np.zeros((HEIGHT, WIDTH), np.int32)
    triangle[:, 45:] = 1
    triangle[:5] = -1
    place = np.zeros((HEIGHT, WIDTH, 2))
    image = GreyImage(np.zeros((HEIGHT, WIDTH), "f4"), triangle >= 0)
    ids = np.arange(4)
    chart = Chart(ids, np.array([[0, 1, 2], [1, 3, 2]]), np.arange(2), np.zeros((4, 2)), 4.0)
    areas = np.array([45 * 55 / 16, 45 * 55 / 6])
    distortion = Distortion(np.array([4.0, 3.0]), np.array([4.0, 2.0]), areas)
    calibrated = CalibratedImage(image, chart, triangle, place)
    return FlattenedSurface(calibrated, distortion, "bff", "why", 5.0, 1.0, 1.2)


def _results(status):
    rows, columns = np.mgrid[0:HEIGHT:SPACING, 0:WIDTH:SPACING].astype(float)
    shape = rows.shape
    place = np.stack([columns, rows], axis=-1)
    ok = status == PointStatus.OK
    there = np.where(ok[..., None], place, np.nan)
    grid = CorrelationGrid(
        place, there, np.zeros((*shape, 2, 2)), np.ones(shape), np.ones(shape, int),
        np.ones((*shape, 2)), status, SPACING, 21, 0.5,
    )  # fmt: skip
    space = np.where(ok[..., None], 1.0, np.nan) * np.ones(3)
    tracked = TrackedSurface(
        space, space, space, space, np.ones(shape), status, np.array([0.0, 0.0])
    )
    tried = status != PointStatus.OUTSIDE_MASK
    arrays = {"status": status[tried].astype(float)}
    places, cells = np.zeros((int(tried.sum()), 3)), np.zeros((0, 4), int)
    measurement = Measurement(places, cells, arrays, np.flatnonzero(tried))
    pair = FlattenedPair(_surface(), _surface())
    return RunResults(pair, None, None, grid, tracked, None, None, measurement, {}, None, None)


def _status():
    status = np.zeros((HEIGHT // SPACING, WIDTH // SPACING), "u1")
    status[0] = PointStatus.OUTSIDE_MASK
    return status


def test_a_full_grid_covers_the_whole_surface():
    found = measured_share(_results(_status()))
    # 9 of 18 columns on each half; 25 px^2 a point on 16 and on 6 px^2/mm^2
    assert found["area_mm2"] == pytest.approx(11 * 9 * (25 / 16 + 25 / 6))
    assert found["share_of_region"] == 1.0
    assert found["share_of_surface"] == pytest.approx(1.0)


def test_a_lost_half_counts_by_its_area_not_by_its_points():
    status = _status()
    status[1:, 9:] = PointStatus.LOW_ZNCC
    found = measured_share(_results(status))
    assert found["share_of_region"] == pytest.approx(6 / (16 + 6))
    assert point_figures(status)["ok_share"] == 0.5


def test_what_was_not_asked_for_lowers_the_share_of_the_surface_only():
    status = _status()
    status[1:, 9:] = PointStatus.OUTSIDE_MASK
    found = measured_share(_results(status))
    assert found["share_of_region"] == 1.0
    assert found["share_of_surface"] == pytest.approx(6 / (16 + 6))


def test_cells_that_reach_too_far_do_not_hide_what_is_lost():
    status = _status()
    status[1:, :1] = PointStatus.LOW_ZNCC
    results = _results(status)
    surface = results.pair.reference
    smaller = replace(surface, distortion=replace(surface.distortion, area=np.full(2, 100.0)))
    found = measured_share(replace(results, pair=FlattenedPair(smaller, smaller)))
    assert found["share_of_surface"] == found["share_of_region"] < 1.0


def test_percentiles_leave_out_what_is_missing():
    found = spread(np.array([np.nan, 1.0, 2.0, 3.0, np.nan]))
    assert found["median"] == 2.0
    assert found["max"] == 3.0
    assert np.isnan(spread(np.array([np.nan]))["median"])


EVEN = {"method": "bff", "flips": 0, "texels_per_px": 1, "anisotropy": {"p95": 1.1}}
GOOD = {
    "points": {"total": 1000, "ok": 990, "ok_share": 0.99, "statuses": {"OK": 990, "OUTLIER": 10}},
    "match": {"fold_share": 0.0, "residual_px": 0.4, "pairs": 900},
    "morph": {"law": "fe", "matches_instead_of_law": 400},
    "correlate": {"subset_size_px": 21, "zncc": {"median": 0.97}, "sigma_px": {"p95": 0.03}},
    "flatten": {"reference": {**EVEN, "texels_per_px": 1.3}},
    "inputs": {"reference_size": 70.0},
    "strain": {"gauge_mm": 4.3},
    "align": {"rms_mm": 0.01, "method": "points", "carried_share": 0.4},
}


def _with(section, **changes):
    sections = copy.deepcopy(GOOD)
    sections[section].update(changes)
    return sections


def test_a_sound_run_passes_without_reasons():
    assert judge(GOOD) == {"level": "PASS", "reasons": []}


@pytest.mark.parametrize(
    ("sections", "level", "says"),
    [
        (_with("points", ok_share=0.8), "WARN", "80.0% of 1000 points"),
        (_with("points", ok_share=0.4), "FAIL", "OUTLIER (10)"),
        (_with("match", fold_share=0.02), "WARN", "folds over on 2.00%"),
        (_with("match", residual_px=9.0), "WARN", "scatter by 9.0 px"),
        (_with("morph", matches_instead_of_law=600), "WARN", "fe leads nowhere at 600 of 900"),
        (_with("correlate", zncc={"median": 0.7}), "WARN", "median ZNCC 0.70"),
        (_with("correlate", sigma_px={"p95": 0.16}), "WARN", "random errors of 0.16 px"),
        (_with("flatten", deformed=EVEN | {"flips": 3}), "WARN", "3 triangles"),
        (_with("flatten", deformed=EVEN | {"texels_per_px": 0.4}), "WARN", "0.40 texels"),
        (_with("flatten", deformed=EVEN | {"anisotropy": {"p95": 8.9}}), "WARN", "8.9 : 1"),
        (_with("align", rms_mm=2.0), "WARN", "2 mm rms"),
        (_with("align", carried_share=0.03), "WARN", "only 3.0%"),
        (_with("inputs", reference_size=70_000.0), "WARN", "70000 mm across: check inputs.units"),
        (_with("strain", gauge_mm=14.5), "WARN", "averaged over 14.5 mm, on an object of 70 mm"),
    ],
)
def test_each_weakness_has_its_level_and_a_reason_with_its_figure(sections, level, says):
    found = judge(sections)
    assert found["level"] == level
    assert len(found["reasons"]) == 1
    assert says in found["reasons"][0]


def test_landmarks_that_carry_the_shapes_apart_are_a_reason():
    sections = _with("align", method="landmarks")
    sections["displacement_mm"] = {"median": 36.0}
    found = judge(sections)
    assert found["level"] == "WARN"
    assert len(found["reasons"]) == 1
    assert "36 mm or more, on an object of 70 mm" in found["reasons"][0]
    sections["displacement_mm"] = {"median": 34.0}
    assert judge(sections)["level"] == "PASS"


@pytest.mark.parametrize("size", [0.07, 0.999, 10010])
def test_a_size_that_speaks_of_a_wrong_unit_is_a_reason(size):
    sections = _with("inputs", reference_size=size)
    sections["strain"]["gauge_mm"] = sections["align"]["rms_mm"] = size / 1000
    assert judge(sections) == {
        "level": "WARN",
        "reasons": [f"WARN: the object measures {size} mm across: check inputs.units"],
    }


@pytest.mark.parametrize("size", [1.0, 5.0, 3000.0, 10_000.0])
def test_small_samples_and_large_panels_pass(size):
    sections = _with("inputs", reference_size=size)
    sections["strain"]["gauge_mm"] = sections["align"]["rms_mm"] = size / 1000
    assert judge(sections)["level"] == "PASS"


def test_two_pictures_are_judged_by_what_they_have():
    assert judge({name: GOOD[name] for name in ("points", "match", "correlate")})["level"] == "PASS"
