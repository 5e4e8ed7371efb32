"""Writing a synthetic case: over an earlier one, never over somebody's scans."""

import pytest

from shapemorph.config import SynthesizeConfig
from shapemorph.core.errors import ConfigError
from shapemorph.pipeline.synthesize import write_case

SMALL = SynthesizeConfig(shape="rigid", faces=300, texture=64, speckle=8)


def test_a_case_is_made_again_in_its_folder(tmp_path):
    first = write_case(SMALL, tmp_path)
    assert write_case(SMALL, tmp_path) == first


def test_meshes_of_another_origin_are_left_alone(tmp_path):
    (tmp_path / "reference.obj").write_text("a scan")
    with pytest.raises(ConfigError, match=r"holds reference\.obj and is no synthetic case"):
        write_case(SMALL, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["reference.obj"]
    assert (tmp_path / "reference.obj").read_text() == "a scan"
