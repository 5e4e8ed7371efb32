import json

import pytest

from shapemorph.core.errors import DataError
from shapemorph.io.noise_files import QUANTITIES, read_noise


def test_mean_and_deviation_come_back(tmp_path):
    figures = {name: {"mean": 0.1 * k, "std": k, "ratio": 1} for k, name in enumerate(QUANTITIES)}
    path = tmp_path / "noise.json"
    path.write_text(json.dumps({"figures": {"points": 7, **figures}, "notes": []}))
    assert read_noise(path)["v"] == {"mean": 0.1, "std": 1.0}


@pytest.mark.parametrize("content", ["", "[1]", "{}", '{"figures": {"u": {"mean": 1}}}'])
def test_other_files_are_refused(tmp_path, content):
    path = tmp_path / "other.json"
    path.write_text(content)
    with pytest.raises(DataError, match=r"expected the noise\.json that `shapemorph noise` writes"):
        read_noise(path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(DataError, match=r"gone\.json cannot be read"):
        read_noise(tmp_path / "gone.json")
