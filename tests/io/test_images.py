"""Pictures of every kind become grey in [0, 1], or one clear error."""

import io

import cv2
import numpy as np
import pytest
from PIL import Image

from shapemorph.core.errors import DataError
from shapemorph.io.images import decode_picture, read_grey_image, read_picture, write_grey_png

HEIGHT, WIDTH = 13, 22
ONE_LEVEL = 1.0 / 255.0


def colour_levels(depth=np.uint8):
    full = np.iinfo(depth).max
    return np.random.default_rng(3).integers(
        0, full, (HEIGHT, WIDTH, 3), dtype=depth, endpoint=True
    )


def luma(rgb):
    full = np.iinfo(rgb.dtype).max
    red, green, blue = (rgb[..., k] / full for k in range(3))
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def encoded(picture, file_format, **options):
    buffer = io.BytesIO()
    picture.save(buffer, format=file_format, **options)
    return buffer.getvalue()


def opencv_encoded(rgb, suffix):
    return cv2.imencode(suffix, np.ascontiguousarray(rgb[..., ::-1]))[1].tobytes()


@pytest.mark.parametrize("file_format", ["PNG", "TIFF", "BMP", "TGA"])
def test_colour_becomes_rec_709_luma(file_format):
    rgb = colour_levels()
    picture = decode_picture(encoded(Image.fromarray(rgb), file_format), name="p")
    assert picture.grey.dtype == np.float32
    np.testing.assert_allclose(picture.grey, luma(rgb), atol=1e-6)
    assert picture.opaque.all()
    assert picture.notes == ()


@pytest.mark.parametrize("suffix", [".png", ".tiff"])
def test_sixteen_bit_colour_keeps_its_lower_byte(suffix):
    rgb = colour_levels(np.uint16)
    picture = decode_picture(opencv_encoded(rgb, suffix), name="p")
    np.testing.assert_allclose(picture.grey, luma(rgb), atol=1e-6)


@pytest.mark.parametrize("file_format", ["PNG", "TIFF"])
def test_sixteen_bit_grey_is_scaled_by_its_full_range(file_format):
    levels = np.arange(HEIGHT * WIDTH, dtype=np.uint16).reshape(HEIGHT, WIDTH) * 17
    picture = decode_picture(encoded(Image.fromarray(levels), file_format), name="p")
    np.testing.assert_allclose(picture.grey, levels / 65535.0, atol=1e-7)


def test_big_endian_sixteen_bit_tiff_is_read_in_its_own_order():
    levels = np.arange(HEIGHT * WIDTH, dtype=np.uint16).reshape(HEIGHT, WIDTH) * 17
    picture = Image.frombytes("I;16B", (WIDTH, HEIGHT), levels.astype(">u2").tobytes())
    grey = decode_picture(encoded(picture, "TIFF"), name="p").grey
    np.testing.assert_allclose(grey, levels / 65535.0, atol=1e-7)


def test_grey_palette_and_one_bit_pictures_agree_with_their_colours():
    grey = colour_levels()[..., 0]
    plain = decode_picture(encoded(Image.fromarray(grey), "PNG"), name="p").grey
    np.testing.assert_allclose(plain, grey / 255.0, atol=1e-7)
    palette = Image.fromarray(colour_levels()).quantize(16)
    expected = luma(np.asarray(palette.convert("RGB")))
    np.testing.assert_allclose(
        decode_picture(encoded(palette, "PNG"), name="p").grey, expected, atol=1e-6
    )
    two = Image.fromarray(grey > 100)
    np.testing.assert_array_equal(decode_picture(encoded(two, "PNG"), name="p").grey, grey > 100)


def test_cmyk_pictures_are_understood():
    rgb = colour_levels()
    cmyk = Image.fromarray(255 - rgb).convert("RGB")
    stored = Image.merge("CMYK", (*cmyk.split(), Image.new("L", (WIDTH, HEIGHT), 0)))
    grey = decode_picture(encoded(stored, "TIFF"), name="p").grey
    np.testing.assert_allclose(grey, luma(rgb), atol=ONE_LEVEL)


@pytest.mark.parametrize("mode", ["RGBA", "LA"])
def test_alpha_becomes_the_mask_and_is_noted(mode):
    rgb = np.repeat(colour_levels()[..., :1], 3, axis=2)
    alpha = np.zeros((HEIGHT, WIDTH), dtype=np.uint8)
    alpha[2:9, 5:] = 200
    picture = Image.fromarray(rgb)
    picture.putalpha(Image.fromarray(alpha))
    decoded = decode_picture(encoded(picture.convert(mode), "PNG"), name="p")
    np.testing.assert_array_equal(decoded.opaque, alpha > 0)
    np.testing.assert_allclose(decoded.grey, rgb[..., 0] / 255.0, atol=1e-6)
    assert "transparent" in decoded.notes[0]


def test_transparent_palette_entries_are_outside_the_mask():
    levels = np.arange(HEIGHT * WIDTH, dtype=np.uint8).reshape(HEIGHT, WIDTH) % 4
    picture = Image.fromarray(levels, mode=None).convert("P")
    decoded = decode_picture(encoded(picture, "PNG", transparency=2), name="p")
    np.testing.assert_array_equal(decoded.opaque, levels != 2)


@pytest.mark.parametrize(("full", "largest"), [(1.0, 0.83), (255.0, 200.0), (65535.0, 40000.0)])
def test_float_pictures_are_scaled_by_the_range_that_holds_them(full, largest):
    values = np.linspace(0, largest, HEIGHT * WIDTH, dtype=np.float32).reshape(HEIGHT, WIDTH)
    decoded = decode_picture(encoded(Image.fromarray(values), "TIFF"), name="p")
    np.testing.assert_allclose(decoded.grey, values / full, rtol=1e-5)
    assert "taken as grey" in decoded.notes[0]


def test_float_pictures_with_negative_values_are_clipped_to_their_own_range():
    values = np.linspace(-3, 5, HEIGHT * WIDTH, dtype=np.float32).reshape(HEIGHT, WIDTH)
    values[0, 0] = np.nan
    decoded = decode_picture(encoded(Image.fromarray(values), "TIFF"), name="p")
    assert decoded.grey[0, 0] == 0.0
    np.testing.assert_allclose(decoded.grey[1:], (values[1:] + 3) / 8, atol=0.01)


def test_jpeg_is_near_its_source():
    ramp = np.tile(np.linspace(0, 255, 64).astype(np.uint8), (48, 1))
    decoded = decode_picture(encoded(Image.fromarray(ramp), "JPEG", quality=95), name="p")
    np.testing.assert_allclose(decoded.grey, ramp / 255.0, atol=3 * ONE_LEVEL)


@pytest.mark.parametrize("file_format", ["PNG", "JPEG", "TIFF", "BMP"])
@pytest.mark.parametrize("share", [0.02, 0.5, 0.9])
def test_truncated_pictures_are_refused(file_format, share):
    data = encoded(Image.fromarray(np.tile(colour_levels(), (9, 9, 1))), file_format)
    with pytest.raises(DataError, match="p: expected"):
        decode_picture(data[: int(share * len(data))], name="p")


@pytest.mark.parametrize("suffix", [".png", ".tiff"])
def test_truncated_deep_colour_is_refused(suffix):
    data = opencv_encoded(np.tile(colour_levels(np.uint16), (5, 5, 1)), suffix)
    with pytest.raises(DataError, match="p: expected"):
        decode_picture(data[: len(data) * 2 // 3], name="p")


def test_a_flipped_byte_in_a_png_is_found_by_its_checksum():
    data = bytearray(encoded(Image.fromarray(colour_levels()), "PNG"))
    data[len(data) // 2] ^= 4
    with pytest.raises(DataError, match="damaged"):
        decode_picture(bytes(data), name="p")


def test_a_png_whose_data_do_not_match_their_checksum_is_refused():
    data = bytearray(encoded(Image.fromarray(colour_levels()), "PNG"))
    end = data.rindex(b"IEND") - 4
    data[end - 1] ^= 1  # last byte of the checksum of the picture's data
    with pytest.raises(DataError, match="damaged"):
        decode_picture(bytes(data), name="p")


def test_a_header_that_claims_gigabytes_is_refused_before_they_are_reserved():
    data = bytearray(encoded(Image.fromarray(colour_levels()), "BMP"))
    data[18:26] = np.array([60000, 60000], dtype="<i4").tobytes()
    with pytest.raises(DataError, match="claims 60000 x 60000"):
        decode_picture(bytes(data), name="p")


def test_missing_empty_and_foreign_files_are_refused(tmp_path):
    with pytest.raises(DataError, match="does not exist"):
        read_grey_image(tmp_path / "none.png")
    with pytest.raises(DataError, match="folder"):
        read_grey_image(tmp_path)
    (tmp_path / "empty.png").write_bytes(b"")
    with pytest.raises(DataError, match="empty"):
        read_grey_image(tmp_path / "empty.png")
    np.savez(tmp_path / "truth.npz", shape=np.array("dome"))
    (tmp_path / "text.png").write_text("no picture at all")
    for name in ("truth.npz", "text.png"):
        with pytest.raises(DataError, match=f"^{name} is not a picture: expected PNG, TIFF"):
            read_grey_image(tmp_path / name)


@pytest.mark.parametrize("file_format", ["PNG", "JPEG", "BMP"])
def test_a_picture_without_its_header_is_called_damaged(file_format):
    data = encoded(Image.fromarray(colour_levels()), file_format)
    with pytest.raises(DataError, match="got a truncated or damaged one") as caught:
        decode_picture(data[:5], name="p")
    assert "BytesIO" not in str(caught.value)


def test_first_of_several_pages_is_used_and_said():
    pages = [Image.fromarray(colour_levels()[..., k]) for k in range(2)]
    data = encoded(pages[0], "TIFF", save_all=True, append_images=pages[1:])
    decoded = decode_picture(data, name="p")
    np.testing.assert_allclose(decoded.grey, colour_levels()[..., 0] / 255.0, atol=1e-7)
    assert "first of its 2 pictures" in decoded.notes[0]


def test_written_grey_comes_back_within_half_a_level_with_its_mask(tmp_path):
    grey = np.random.default_rng(1).random((HEIGHT, WIDTH), dtype=np.float32)
    mask = np.ones((HEIGHT, WIDTH), dtype=bool)
    mask[:4, 7:] = False
    path = tmp_path / "written grey.png"
    write_grey_png(path, grey, mask)
    back = read_grey_image(path)
    np.testing.assert_array_equal(back.mask, mask)
    np.testing.assert_allclose(back.grey[mask], grey[mask], atol=0.5 * ONE_LEVEL + 1e-6)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_a_place_that_cannot_be_written_is_a_clear_error(tmp_path):
    grey, mask = np.zeros((4, 5), dtype=np.float32), np.ones((4, 5), dtype=bool)
    with pytest.raises(DataError, match="cannot write"):
        write_grey_png(tmp_path / "nowhere" / "p.png", grey, mask)


def test_a_channel_of_the_colours_may_become_grey(tmp_path):
    stored = np.random.default_rng(0).integers(0, 256, (20, 30, 3), dtype=np.uint8)
    Image.fromarray(stored).save(tmp_path / "colours.png")
    picture = read_picture(tmp_path / "colours.png", "green")
    np.testing.assert_allclose(picture.grey, stored[..., 1] / 255, atol=1e-6)
    assert len(picture.content) == 4
    Image.fromarray(stored[..., 0]).save(tmp_path / "grey.png")
    assert read_picture(tmp_path / "grey.png", "green").content == ()
