"""truth.npz and the folder of a pair."""

import io
import os

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.config import DamageConfig, SynthesizeConfig
from shapemorph.core.errors import DataError
from shapemorph.io.truth_files import read_truth, write_pair, write_truth
from shapemorph.methods.synthetic.truth import random_material, truth_at, truth_of_material
from shapemorph.stages.synthesize import synthesize


@pytest.fixture(scope="module")
def pair():
    return synthesize(
        SynthesizeConfig(
            shape="indentation",
            offset=4.0,
            tilt=-3.0,
            faces=600,
            texture=128,
            speckle=4.0,
            damage=DamageConfig(lost_patch=True, glare=True),
        )
    )


def test_a_truth_read_back_says_the_same(tmp_path, pair):
    found = read_truth(write_truth(tmp_path / "truth.npz", pair.truth))
    exact = truth_of_material(pair.truth, random_material(pair.truth, 400, inset=1.0, seed=0))
    again = truth_at(found, exact.reference)
    assert_allclose(again.deformed, exact.deformed, atol=1e-10)
    assert_allclose(again.e1, exact.e1, atol=1e-10)
    assert np.array_equal(again.visible, exact.visible)
    assert_allclose(found.table.deformed, pair.truth.table.deformed, rtol=0, atol=0.51e-10)
    assert [spot.kind for spot in found.damage] == ["glare", "lost_patch"]


def test_the_arrays_are_there_for_those_who_only_have_numpy(tmp_path, pair):
    with np.load(write_truth(tmp_path / "truth.npz", pair.truth), allow_pickle=False) as arrays:
        count = len(arrays["reference"])
        assert str(arrays["shape"]) == "indentation"
        assert arrays["deformed"].shape == (count, 3)
        for name in ("E1", "E2", "rim_distance", "kink_distance", "visible"):
            assert arrays[name].shape == (count,)
        body = arrays["reference"] - arrays["reference_file_from_body"][:3, 3]
        body = body @ arrays["reference_file_from_body"][:3, :3]
    assert_allclose(body[:, 2], 0, atol=1e-10)  # the membrane was flat; the table is rounded


def test_a_pair_fills_its_folder_and_nothing_else(tmp_path, pair):
    files = write_pair(tmp_path / "new" / "case", pair, file_format="obj")
    names = sorted(file.name for file in (tmp_path / "new" / "case").iterdir())
    assert names == sorted(file.name for file in files)
    assert names == sorted(
        ["truth.npz"]
        + [f"{side}.{end}" for side in ("reference", "deformed") for end in ("obj", "mtl", "png")]
    )


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_cannot_be_written_is_one_clear_error(tmp_path, pair):
    tmp_path.chmod(0o500)
    with pytest.raises(DataError, match="cannot write into"):
        write_pair(tmp_path / "case", pair, file_format="obj")


def test_a_file_in_the_way_is_one_clear_error(tmp_path, pair):
    (tmp_path / "case").write_text("in the way")
    with pytest.raises(DataError, match="cannot write into"):
        write_pair(tmp_path / "case", pair, file_format="obj")


def test_a_failed_write_leaves_nothing(tmp_path, pair):
    with pytest.raises(DataError, match="vertex colours only"):
        write_pair(tmp_path / "case", pair, file_format="ply")
    assert list((tmp_path / "case").iterdir()) == []


def _one_array():
    buffer = io.BytesIO()
    np.save(buffer, np.zeros(3))
    return buffer.getvalue()


@pytest.mark.parametrize(
    "content",
    [b"", b"not a zip", b"PK\x03\x04 broken", b"\x89PNG\r\n\x1a\n a picture", _one_array()],
)
def test_what_is_not_a_truth_is_refused_without_the_advice_of_a_library(tmp_path, content):
    path = tmp_path / "truth.npz"
    with pytest.raises(DataError, match="found no file"):
        read_truth(path)
    path.write_bytes(content)
    with pytest.raises(DataError, match=r"is not a truth file: expected the truth\.npz") as caught:
        read_truth(path)
    assert "pickle" not in str(caught.value)


def test_another_npz_is_refused(tmp_path):
    np.savez(tmp_path / "other.npz", shape=np.array("dome"))
    with pytest.raises(DataError, match=r"is not a truth file.*lacks the array 'material'"):
        read_truth(tmp_path / "other.npz")
