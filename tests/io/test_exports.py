"""Exports hold what measurement.vtp holds, under the same names."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scipy.io import loadmat

from shapemorph.core.errors import ConfigError
from shapemorph.core.measurement import Measurement
from shapemorph.io.exports import FORMATS, exported_arrays, write_export


@pytest.fixture
def measurement():
    rng = np.random.default_rng(3)
    arrays = {
        "status": np.array([0, 0, 0, 0, 6], dtype=np.uint8),
        "chart": np.zeros(5, dtype=np.int64),
        "E1": np.where(np.arange(5) < 4, rng.normal(size=5), np.nan),
        "direction_1_deformed": rng.normal(size=(5, 3)),
        "deformed_px": rng.normal(size=(5, 2)),
    }
    return Measurement(rng.normal(size=(5, 3)), np.array([[0, 1, 3, 2]]), arrays)


FIELDS = {"units": "mm", "config": '{"strain": {"window": 5}}'}


def test_npz_needs_no_pickle_and_keeps_every_bit_and_type(tmp_path, measurement):
    path = write_export(tmp_path / "measurement", measurement, FIELDS, "npz")
    with np.load(path, allow_pickle=False) as archive:
        assert set(archive.files) == {"points", "cells", *measurement.arrays, *FIELDS}
        for name, values in exported_arrays(measurement).items():
            assert_array_equal(archive[name], values)
            assert archive[name].dtype == values.dtype
        assert str(archive["units"]) == "mm"


def test_mat_has_columns_and_the_same_names(tmp_path, measurement):
    found = loadmat(write_export(tmp_path / "measurement", measurement, FIELDS, "mat"))
    assert set(found) - {"__header__", "__version__", "__globals__"} == {
        *("points", "cells"),
        *measurement.arrays,
        *FIELDS,
    }
    assert found["E1"].shape == (5, 1)
    for name, values in exported_arrays(measurement).items():
        assert_array_equal(found[name], values.reshape(len(values), -1))
    assert found["config"].item() == FIELDS["config"]


def test_an_unknown_format_names_those_that_exist(tmp_path, measurement):
    with pytest.raises(ConfigError, match=f"{', '.join(FORMATS)}.*'hdf5'"):
        write_export(tmp_path / "measurement", measurement, {}, "hdf5")
    assert not list(tmp_path.iterdir())
