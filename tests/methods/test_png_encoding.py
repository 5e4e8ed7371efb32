"""PNG files of our own, read back by pillow."""

import io

import numpy as np
import pytest
from PIL import Image

from shapemorph.methods.png_encoding import png_bytes


@pytest.mark.parametrize(("channels", "mode"), [(1, "L"), (2, "LA"), (3, "RGB"), (4, "RGBA")])
def test_pixels_come_back_as_they_were(channels, mode):
    pixels = np.random.default_rng(1).integers(0, 256, (17, 31, channels), dtype=np.uint8)
    with Image.open(io.BytesIO(png_bytes(pixels))) as picture:
        assert picture.mode == mode
        assert np.array_equal(np.asarray(picture).reshape(pixels.shape), pixels)
    with Image.open(io.BytesIO(png_bytes(pixels))) as again:
        again.verify()


def test_rows_apart_in_memory_are_taken_in_order():
    pixels = np.arange(2 * 3 * 5, dtype=np.uint8).reshape(2, 5, 3)[::-1, ::2]
    with Image.open(io.BytesIO(png_bytes(pixels))) as picture:
        assert np.array_equal(np.asarray(picture), pixels)


def test_a_file_says_at_what_density_it_should_be_shown():
    content = png_bytes(np.zeros((4, 4, 3), np.uint8), per_inch=100)
    with Image.open(io.BytesIO(content)) as picture:
        assert picture.info["dpi"] == pytest.approx((100, 100), abs=0.01)
