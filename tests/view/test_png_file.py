import io

import numpy as np
import pytest
from PIL import Image

from shapemorph.view.png_file import png_content


@pytest.mark.parametrize(("shape", "level"), [((1, 1, 3), 1), ((7, 3, 3), 6), ((40, 61, 3), 1)])
def test_png_holds_every_pixel(shape, level):
    pixels = np.random.default_rng(1).integers(0, 256, shape, dtype=np.uint8)
    with Image.open(io.BytesIO(png_content(pixels, 200.0, level))) as picture:
        picture.load()
        assert (picture.format, picture.mode) == ("PNG", "RGB")
        np.testing.assert_allclose(picture.info["dpi"], 200.0, rtol=1e-4)
        np.testing.assert_array_equal(np.asarray(picture), pixels)


def test_png_takes_pixels_that_do_not_lie_in_a_row():
    pixels = np.arange(4 * 5 * 4, dtype=np.uint8).reshape(4, 5, 4)[::-1, :, :3]
    with Image.open(io.BytesIO(png_content(pixels, 100.0, 1))) as picture:
        np.testing.assert_array_equal(np.asarray(picture), pixels)
