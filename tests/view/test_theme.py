import base64
import io

import numpy as np
import pytest
from PIL import Image

from shapemorph.view.style import FAINT, INK, new_figure, place_axes, place_pixels, write_text
from shapemorph.view.theme import THEMES, drawn, embedded, png


def _figure():
    figure = new_figure(200, 120)
    green = np.zeros((30, 40, 3), dtype=np.uint8)
    green[..., 1] = 200
    place_pixels(figure, 20, 60, lambda drawn_at: green.repeat(drawn_at, 0).repeat(drawn_at, 1))
    write_text(figure, 5, 5, "ink", colour=INK)
    write_text(figure, 105, 5, "faint", colour=FAINT)
    axes = place_axes(figure, 120, 50, 60, 40)
    axes.tick_params(colors=INK)
    return figure


def _pixels(figure, theme):
    content = png(drawn(figure, theme), theme)
    return np.asarray(Image.open(io.BytesIO(content)).convert("RGB")).astype(int)


@pytest.mark.parametrize(("name", "ratio"), [("light", 1), ("print", 2)])
def test_pictures_stand_in_their_place_pixel_for_pixel(name, ratio):
    pixels = _pixels(_figure(), THEMES[name])
    assert pixels.shape == (120 * ratio, 200 * ratio, 3)
    green = (pixels == [0, 200, 0]).all(axis=2)
    rows, columns = np.nonzero(green)
    assert green.sum() == 30 * 40 * ratio**2
    assert (rows.min(), columns.min()) == (60 * ratio, 20 * ratio)


def test_print_is_black_on_white():
    light, paper = (_pixels(_figure(), THEMES[n]) for n in ("light", "print"))
    for pixels, top in ((light, 40), (paper, 80)):
        words = pixels[:top]
        half = words.shape[1] // 2
        ink, faint = words[:, :half].min(axis=(0, 1)), words[:, half:].min(axis=(0, 1))
        if pixels is light:
            assert tuple(ink) == (0x1D, 0x24, 0x30)
            assert tuple(faint) == (0x6B, 0x72, 0x80)
        else:
            assert tuple(ink) == (0, 0, 0)
            assert tuple(faint) == (0x26, 0x26, 0x26)
    assert tuple(light[0, 0]) == tuple(paper[0, 0]) == (255, 255, 255)


@pytest.mark.parametrize(("name", "kind"), [("light", "png"), ("print", "webp")])
def test_pages_hold_the_very_pixels_of_a_figure(name, kind):
    content = png(drawn(_figure(), THEMES[name]), THEMES[name])
    source, width = embedded(content, THEMES[name])
    head, _, body = source.partition(",")
    assert head == f"data:image/{kind};base64"
    inside = Image.open(io.BytesIO(base64.b64decode(body)))
    assert inside.width == width
    np.testing.assert_array_equal(inside.convert("RGB"), Image.open(io.BytesIO(content)))


def test_pages_for_paper_hold_pictures_with_noise_in_less_space():
    grey = np.random.default_rng(0).normal(128, 12, (300, 400, 1)).astype(np.uint8)
    content = png(np.repeat(grey, 3, axis=2), THEMES["print"])
    paper, _ = embedded(content, THEMES["print"])
    assert len(paper) < 0.8 * len(content) * 4 / 3


def test_a_picture_too_long_for_webp_is_held_as_it_is():
    content = png(np.zeros((2, 16_400, 3), dtype=np.uint8), THEMES["print"])
    source, width = embedded(content, THEMES["print"])
    assert source.startswith("data:image/png;base64,")
    assert width == 16_400
