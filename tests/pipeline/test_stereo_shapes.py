"""What the measurement of two reconstructed shapes is told."""

import pytest

from shapemorph.config import RunConfig
from shapemorph.config.correlate import MOST_SIGMA
from shapemorph.pipeline.stereo_shapes import of_meshes


@pytest.mark.parametrize(("given", "used"), [(None, MOST_SIGMA), (0.2, 0.2)])
def test_shapes_are_not_aligned_and_random_errors_limited(tmp_path, given, used):
    config = RunConfig.model_validate({"correlate": {"max_sigma": given, "order": 2}})
    found = of_meshes(config, tmp_path)
    assert found.inputs.deformed == tmp_path / "deformed.obj"
    assert found.align.method == "none"
    assert found.correlate.max_sigma == used
    assert found.correlate.order == 2
