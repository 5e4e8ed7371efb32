"""docs/forming.md: its example runs, and what it says about the results is so."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from shapemorph.cli import main
from shapemorph.cli.words import describe_run
from shapemorph.io.measurement_files import read_csv, read_vtp
from shapemorph.io.quantities import QUANTITIES

PAGE = Path(__file__).parents[2] / "docs" / "forming.md"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def formed(measured, pair, tmp_path_factory):
    """Run of the page's example on a copy of the finished run."""
    text = PAGE.read_text(encoding="utf-8")
    folder = tmp_path_factory.mktemp("formed")
    shutil.copytree(measured, folder / "RUN")
    (folder / "limit.csv").write_text(re.search(r"```csv\n(.*?)```", text, re.DOTALL)[1])
    example = re.search(r"```yaml\n(.*?)```", text, re.DOTALL)[1]
    for side in ("reference", "deformed"):
        example = example.replace(f"{side}.obj", str(pair / f"{side}.obj"))
    (folder / "bulge.yaml").write_text(example, encoding="utf-8")
    words = ["-o", str(folder / "RUN"), "--set", "report.figures=false", "--quiet"]
    assert main(["run", str(folder / "bulge.yaml"), *words]) == 0
    return folder / "RUN"


@pytest.fixture(scope="module")
def summary(formed):
    return json.loads((formed / "summary.json").read_text(encoding="utf-8"))["forming"]


def test_the_arrays_that_were_asked_for_are_there_as_listed(formed):
    field, _ = read_vtp(formed / "measurement.vtp")
    asked = {q.name for q in QUANTITIES if q.only_with}
    assert asked <= set(field.arrays)
    np.testing.assert_allclose(
        field.arrays["thickness"], 1.35 * (1 - field.arrays["thinning"]), rtol=1e-12
    )
    table = read_csv(formed / "measurement.csv")
    np.testing.assert_allclose(table["limit_margin"], field.arrays["limit_margin"], rtol=1e-9)


def test_the_most_critical_point_has_the_smallest_margin_and_a_caveat(formed, summary):
    field, _ = read_vtp(formed / "measurement.vtp")
    found = summary["diagram"]
    row = found["critical_point"]["row"]
    assert field.arrays["limit_margin"][row] == np.nanmin(field.arrays["limit_margin"])
    assert found["points_above_curve"] == (field.arrays["limit_margin"] < 0).sum() > 0
    thickness, strain = found["caveats"]
    assert thickness == "thickness: the curve is for 0.8 mm, the specimen has 1.35 mm"
    # The pole is stretched most, and alike in all directions: beyond the curve.
    beyond = field.arrays["hencky_1"][(field.arrays["hencky_2"] > 0.6)]
    assert found["points_beyond_ends_of_curve"] == len(beyond) > 0
    assert f"{len(beyond)} points lie beyond the ends" in strain
    assert f"eps1 up to {beyond.max():.3g} where the most critical one has" in strain


def test_sections_lie_in_their_planes(formed, summary):
    for section in summary["sections"]:
        table = read_csv(formed / "sections" / f"{section['name']}.csv")
        places = np.stack([table[f"{axis}_ref_mm"] for axis in "xyz"], axis=1)
        off = (places - section["point_mm"]) @ section["normal"]
        np.testing.assert_allclose(off, 0, atol=1e-7)
        assert section["length_mm"] > 60
        assert np.nanmax(table["E1"]) > 1


def test_the_words_on_the_screen_name_the_point_its_margin_and_the_caveat(formed):
    found = json.loads((formed / "summary.json").read_text(encoding="utf-8"))
    text = "\n".join(describe_run(formed, found))
    assert re.search(r"^limit {7}margin -?[0-9.]+ there .* points above the curve$", text, re.M)
    assert "caveat: thickness: the curve is for 0.8 mm, the specimen has 1.35 mm" in text
    assert re.search(r"^dome {8}height .* mm.* membrane stress [0-9.]+ MPa$", text, re.M)
    smallest = found["forming"]["diagram"]["smallest_margin"]
    assert found["scorecard"]["limit margin, smallest"] == smallest


def test_the_dome_has_a_pole_and_a_stress(summary):
    dome = summary["dome"]
    expected = 0.8 * dome["pole_radius_mm"] / (2 * dome["pole_thickness_mm"])
    assert dome["membrane_stress_MPa"] == pytest.approx(expected)
    assert 0.2 < dome["pole_thickness_mm"] < 0.5
    assert dome["sigma_pole_radius_mm"] < 0.1 * dome["pole_radius_mm"]


def test_a_changed_curve_changes_the_results(formed, tmp_path):
    folder = tmp_path / "RUN"
    shutil.copytree(formed, folder)
    curve = tmp_path / "other.csv"
    curve.write_text("eps2,eps1\n-1,2\n1,2\n")
    words = ["--set", f"forming.limit_curve={curve}", "--quiet", "--json"]
    assert main(["run", str(folder), *words]) == 0
    curve.write_text("eps2,eps1\n-1,3\n1,3\n")
    assert main(["run", str(folder), "--quiet"]) == 0
    field, _ = read_vtp(folder / "measurement.vtp")
    ok = field.arrays["status"] == 0
    np.testing.assert_allclose(
        field.arrays["limit_margin"][ok], 3 - field.arrays["hencky_1"][ok], rtol=1e-12
    )


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("forming.pressure=1", "strain.thickness"),
        ("forming.sections=[{name: a, angle: 0, normal: [1, 0, 0]}]", "give one of them"),
        ("forming.sections=[{name: ../a, angle: 0}]", "name"),
        ("forming.material=DC04", "limit_curve"),
        ("forming.limit_curve=/nowhere.csv", "does not exist"),
    ],
)
def test_settings_that_cannot_be_meant_are_one_clear_line(pair, tmp_path, capsys, setting, words):
    files = [str(pair / "reference.obj"), str(pair / "deformed.obj")]
    code = main(["measure", *files, "-o", str(tmp_path / "run"), "--set", setting, "--quiet"])
    assert code in (2, 3)
    assert words in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
