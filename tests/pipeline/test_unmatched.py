"""The picture that a failed match leaves."""

import numpy as np
import pytest
from PIL import Image

from shapemorph.core.errors import StageError
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import UnmatchedError
from shapemorph.pipeline.unmatched import PICTURE, showing_failed_match


def _images():
    rng = np.random.default_rng(2)
    return tuple(
        GreyImage(rng.random(shape).astype(np.float32), np.ones(shape, bool))
        for shape in ((200, 300), (400, 240))
    )


def test_a_failed_match_leaves_a_picture_and_says_where(tmp_path):
    folder = tmp_path / "run"
    points = np.array([[10.0, 20.0], [280.0, 190.0], [150.0, 100.0]])
    says = rf"3 pairs agree; what looked alike: .*{PICTURE}"
    with pytest.raises(StageError, match=says), showing_failed_match(folder, _images):
        raise UnmatchedError("3 pairs agree", points, points * 0.8)
    with Image.open(folder / PICTURE) as picture:
        levels = np.asarray(picture.convert("L"))
    assert levels.shape[1] >= 960
    assert (levels < 100).mean() > 0.05


def test_a_failed_match_without_any_pair_is_drawn_too(tmp_path):
    with pytest.raises(StageError, match=PICTURE), showing_failed_match(tmp_path, _images):
        raise UnmatchedError("none", np.empty((0, 2)), np.empty((0, 2)))
    assert (tmp_path / PICTURE).is_file()


def test_success_removes_the_picture_of_the_last_failure(tmp_path):
    (tmp_path / PICTURE).write_bytes(b"old")
    with showing_failed_match(tmp_path, _images):
        pass
    assert not (tmp_path / PICTURE).exists()
