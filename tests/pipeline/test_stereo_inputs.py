"""Which left picture belongs to which right one."""

import numpy as np
import pytest

from shapemorph.config import RunConfig
from shapemorph.core.errors import DataError
from shapemorph.io.images import write_grey_png
from shapemorph.io.rig_files import write_rig
from shapemorph.methods.synthetic.stereo_rig import stereo_rig
from shapemorph.pipeline.stereo_inputs import stereo_sequence


def sequence_of(folder, left, right):
    rig = stereo_rig(scale=0.1, target=np.zeros(3))
    write_rig(folder / "rig.json", rig)
    width, height = rig.cameras[0].size
    for side, names in (("left", left), ("right", right)):
        (folder / side).mkdir()
        for name in names:
            grey = np.zeros((height, width), dtype=np.float32)
            write_grey_png(folder / side / f"{name}.png", grey, np.ones(grey.shape, dtype=bool))
    inputs = {side: folder / side / "*.png" for side in ("left", "right")}
    return stereo_sequence(RunConfig(inputs={**inputs, "rig": folder / "rig.json"}))


@pytest.mark.parametrize(
    ("left", "right"),
    [
        (["l_00", "l_01", "l_10"], ["r_00", "r_01", "r_10"]),
        (["l_8", "l_9", "l_10"], ["right_08", "right_09", "right_10"]),
        (["img_0000_0", "img_0005_0"], ["img_0000_1", "img_0005_1"]),
        (["before", "after"], ["before", "after"]),
        (["l_120000", "l_120004", "l_120009"], ["r_120001", "r_120004", "r_120010"]),
        (["l_120000", "l_120004"], ["r_120001", "r_120006"]),
    ],
)
def test_pictures_go_together_by_name_or_by_order(tmp_path, left, right):
    found = sequence_of(tmp_path, left, right)
    assert found.states == len(left) == len(found.right)


@pytest.mark.parametrize(
    ("left", "right", "told"),
    [
        (["l_00", "l_01", "l_02"], ["r_00", "r_02"], r"l_01\.png has no partner"),
        (["l_00", "l_02"], ["r_00", "r_01", "r_02"], r"r_01\.png has no partner"),
        (["l_08", "l_09", "l_10"], ["r_08", "r_09"], r"l_10\.png has no partner"),
        (["l_00", "l_01", "l_02"], ["r_00", "r_02", "r_03"], r"got l_01\.png beside r_02\.png"),
        (["l_1", "l_2", "l_3"], ["r_0", "r_1", "r_2"], r"got l_1\.png beside r_0\.png"),
    ],
)
def test_a_missing_picture_is_named(tmp_path, left, right, told):
    with pytest.raises(DataError, match=f"{told}.*: is a picture missing"):
        sequence_of(tmp_path, left, right)


def test_names_without_anything_in_common_are_counted(tmp_path):
    with pytest.raises(DataError, match=r"got 2 of .* and 3 of .*\*\.png: is a picture missing"):
        sequence_of(tmp_path, ["a_1", "a_2"], ["r_11", "r_12", "r_13"])
