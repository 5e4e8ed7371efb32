"""Sequences of pictures, in files or in pages."""

import numpy as np
import pytest
from PIL import Image

from shapemorph.core.errors import DataError
from shapemorph.io.frames import list_frames, read_frame, read_only_picture, whole_pages


def levels(value, dtype=np.uint8):
    return np.full((6, 9), value, dtype=dtype)


def stack(path, pictures):
    first, *others = (Image.fromarray(picture) for picture in pictures)
    first.save(path, save_all=True, append_images=others)


def test_numbers_in_names_count_as_numbers(tmp_path):
    for number in (10, 9, 1, 100):
        Image.fromarray(levels(number)).save(tmp_path / f"shot {number}.png")
    frames = list_frames(str(tmp_path / "*.png"))
    assert [frame.name for frame in frames] == ["shot 1", "shot 9", "shot 10", "shot 100"]
    assert read_frame(frames[2]).grey[0, 0] == pytest.approx(10 / 255)


def test_names_stay_apart_where_stems_are_equal(tmp_path):
    for suffix in ("png", "bmp"):
        Image.fromarray(levels(7)).save(tmp_path / f"a.{suffix}")
    names = [frame.name for frame in list_frames(str(tmp_path / "a.*"))]
    assert len(set(names)) == 2
    assert not any("/" in name for name in names)


@pytest.mark.parametrize(("dtype", "full"), [(np.uint8, 255), (np.uint16, 65535)])
def test_pages_of_one_file_are_frames(tmp_path, dtype, full):
    path = tmp_path / "stack.tif"
    stack(path, [levels(k * 20, dtype) for k in range(1, 12)])
    frames = list_frames(str(path))
    assert [frame.name for frame in frames][:2] == ["stack_01", "stack_02"]
    assert len(frames) == 11
    found = [read_frame(frame).grey[0, 0] for frame in frames]
    np.testing.assert_allclose(found, np.arange(1, 12) * 20 / full, rtol=1e-6)


def test_deep_colour_pages_keep_their_lower_byte(tmp_path):
    import cv2

    path = tmp_path / "deep.tif"
    pages = [np.full((6, 9, 3), value, dtype=np.uint16) for value in (257, 5003)]
    assert cv2.imwritemulti(str(path), pages)
    found = [read_frame(frame).grey[0, 0] for frame in list_frames(str(path))]
    np.testing.assert_allclose(found, np.array([257, 5003]) / 65535, rtol=1e-5)


def test_a_file_with_many_pages_is_refused_where_one_picture_is_meant(tmp_path):
    path = tmp_path / "stack.tif"
    stack(path, [levels(1), levels(2), levels(3)])
    with pytest.raises(DataError, match=r"one picture, got 3.*--sequence"):
        read_only_picture(path)
    Image.fromarray(levels(1)).save(tmp_path / "other.tif")
    with pytest.raises(DataError, match=r"stack\.tif holds 3 pictures"):
        list_frames(str(tmp_path / "*.tif"))


def test_a_thumbnail_beside_the_picture_is_not_another_one(tmp_path):
    path = tmp_path / "camera.tif"
    small = Image.fromarray(levels(3)).resize((3, 2))
    small.encoderinfo = {"tiffinfo": {254: 1}}
    Image.fromarray(levels(3)).save(path, save_all=True, append_images=[small])
    assert whole_pages(path) == (0,)
    assert read_only_picture(path).grey.shape == (6, 9)


def test_too_few_pictures_are_an_error(tmp_path):
    Image.fromarray(levels(1)).save(tmp_path / "one.png")
    with pytest.raises(DataError, match="two pictures or more, got 1"):
        list_frames(str(tmp_path / "*.png"))
    with pytest.raises(DataError, match="got 0"):
        list_frames(str(tmp_path / "*.jpg"))
    with pytest.raises(DataError, match="got a folder"):
        list_frames(str(tmp_path))
