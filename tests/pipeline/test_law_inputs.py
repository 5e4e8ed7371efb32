"""What a law reads counts by its content, and only where the law is asked for."""

import numpy as np
import pytest

from shapemorph.config import MorphConfig, RunConfig
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.core.landmarks import Landmarks
from shapemorph.core.laws import LawSpread, RadialProfile
from shapemorph.methods.laws.identity import identity_warp
from shapemorph.pipeline.law_inputs import law_files, law_fingerprint, read_law_inputs
from shapemorph.pipeline.stagelist import STAGES
from shapemorph.pipeline.systematic_figures import systematic_figures


@pytest.fixture
def files(tmp_path):
    (tmp_path / "fe.csv").write_text("r0,r,z\n0,0,1\n2,3,0\n")
    (tmp_path / "dots.csv").write_text("x_ref_px,y_ref_px,x_def_px,y_def_px\n1,2,3,4\n5,6,7,8\n")
    return {"fe": tmp_path / "fe.csv", "dots": tmp_path / "dots.csv"}


def _mark(config, laws, unit="mm", landmarks="none"):
    return law_fingerprint(config, laws, unit, lambda: landmarks)


def test_only_laws_that_are_asked_for_read_their_files(files):
    config = MorphConfig(law="warp", **files)
    assert law_files(config, ["warp", "polynomial"]) == []
    assert law_files(config, ["landmarks", "fe"]) == [files["dots"], files["fe"]]
    before = _mark(config, ["warp"])
    files["fe"].write_text("r0,r,z\n0,0,1\n2,4,0\n")
    assert _mark(config, ["warp"]) == before


def test_content_and_unit_count_wherever_the_file_lies(files, tmp_path):
    config = MorphConfig(law="fe", **files)
    before = _mark(config, ["fe"])
    copy = tmp_path / "copy.csv"
    copy.write_bytes(files["fe"].read_bytes())
    assert _mark(MorphConfig(law="fe", fe=copy), ["fe"]) == before
    assert _mark(config, ["fe"], unit="cm") != before
    files["fe"].write_text("r0,r,z\n0,0,1\n2,4,0\n")
    assert _mark(config, ["fe"]) != before


def test_landmarks_of_the_run_count_only_without_dots(files):
    with_dots, without = MorphConfig(law="landmarks", **files), MorphConfig(law="landmarks")
    laws = ["landmarks"]
    assert _mark(with_dots, laws, landmarks="a") == _mark(with_dots, laws, landmarks="b")
    assert _mark(without, laws, landmarks="a") != _mark(without, laws, landmarks="b")


def _read(config, laws, marks=None):
    return read_law_inputs(config, laws, lambda unit: 10.0 if unit == "cm" else 1.0, lambda: marks)


def test_everything_comes_in_mm_and_px(files):
    config = MorphConfig(law="fe", fe_units="cm", **files)
    found = _read(config, ["fe", "landmarks"])
    assert isinstance(found.finite_elements, RadialProfile)
    assert found.finite_elements.radius.tolist() == [0.0, 30.0]
    assert found.dots.deformed_px.tolist() == [[3, 4], [7, 8]]
    assert found.landmarks is None
    assert _read(config, ["warp"]).finite_elements is None


def test_landmarks_of_the_run_are_used_where_there_are_no_dots():
    marks = Landmarks(("a",), np.zeros((1, 3)), np.ones((1, 3)))
    config = MorphConfig(law="landmarks")
    assert _read(config, ["landmarks"], marks).landmarks is marks
    with pytest.raises(ConfigError, match=r"give morph\.dots or inputs\.landmarks"):
        _read(config, ["landmarks"])


def test_a_missing_file_is_an_error(tmp_path):
    config = MorphConfig(law="fe", fe=tmp_path / "absent.vtu")
    with pytest.raises(DataError, match="absent"):
        _read(config, ["fe"])


def test_a_law_without_its_file_is_refused_by_the_configuration():
    with pytest.raises(ValueError, match=r"give morph\.fe"):
        RunConfig.model_validate({"morph": {"laws": ["fe"]}})


def test_further_laws_do_not_make_the_main_result_again():
    morph = next(stage for stage in STAGES if stage.name == "morph")
    assert {"laws", "images", "fe", "dots"} <= morph.elsewhere
    assert "all_law_inputs" not in morph.reads


def test_the_summary_tells_of_every_law():
    warp = identity_warp((30, 40))
    two = np.array([0.0, 0.003])
    found = LawSpread(
        ("warp", "fe"), (warp, warp), np.array([0.1, 12.0]), np.array([90, 88]), two, 2 * two,
        {"identity": "leads nowhere"},
    )  # fmt: skip
    told = systematic_figures(found)["systematic"]
    assert told["main_law"] == "warp"
    assert told["position_rms_mm"] == 0.003
    assert told["laws"]["fe"] == {
        "law_off_px": 12.0,
        "points_compared": 88,
        "position_rms_mm": 0.003,
        "position_p95_mm": 0.006,
    }
    assert told["failures"] == {"identity": "leads nowhere"}
    assert systematic_figures(None) == {}
    empty = LawSpread((), (), two[:0], np.zeros(0, int), two[:0], two[:0], {})
    assert systematic_figures(empty) == {}
