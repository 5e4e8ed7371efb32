import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from shapemorph.methods.colour_content import CHANNELS, best_channel, gradient_content
from shapemorph.methods.synthetic.planar import planar_speckle

ROWS, COLS = np.mgrid[:200, :260].astype(np.float64)


def speckle(seed=0):
    return planar_speckle(diameter=6.0, seed=seed).at(np.stack([COLS, ROWS], -1))


def colours(amplitudes, noise=0.0, seed=0):
    """One speckle, as strong in every channel as `amplitudes` says, about mid grey; bytes."""
    shade = np.random.default_rng(seed).normal(0, noise, (*ROWS.shape, 3))
    levels = 128 + speckle()[..., None] * np.array(amplitudes) + shade
    return np.clip(np.rint(levels), 0, 255).astype(np.uint8)


def test_content_of_a_wave_is_what_the_blurred_wave_has():
    """sin(2 pi x / 24): slope squared is (2 pi / 24)^2 / 2, the blur takes exp(-(s w)^2)."""
    wave = np.sin(2 * np.pi * COLS / 24)
    content = gradient_content(np.stack([0 * wave, 50 * wave, 10 * wave], -1), 255.0)
    w = 2 * np.pi / 24
    step = (2 * np.sin(w / 2)) ** 2 / 2 * np.exp(-((1.5 * w) ** 2))
    green = step * (50 / 255) ** 2
    assert_allclose(content[2], green, rtol=0.1)
    assert_allclose(content[3], green / 25, rtol=0.1)
    assert content[1] == 0
    assert_allclose(content[0], green * (0.7152 + 0.0722 / 5) ** 2, rtol=0.1)


@pytest.mark.parametrize(
    ("amplitudes", "best"),
    [((20, 20, 20), "luma"), ((5, 25, 5), "luma"), ((30, 0, 0), "red"), ((0, 0, 25), "blue")],
)
def test_channel_with_most_pattern_is_chosen(amplitudes, best):
    contents = [gradient_content(colours(amplitudes, noise=2.0, seed=k), 255.0) for k in range(2)]
    assert best_channel(contents)[0] == best


def test_red_against_green_of_equal_luma_needs_a_channel():
    luma = CHANNELS["luma"]
    content = gradient_content(colours((30, -30 * luma[0] / luma[1], 0)), 255.0)
    channel, reason = best_channel([content, content])
    assert channel == "red"
    assert "relative to luma: red" in reason


def test_noise_does_not_win_over_a_pattern():
    noisy_blue = colours((15, 15, 15), noise=1.0)
    rng = np.random.default_rng(3)
    noisy_blue[..., 2] = np.clip(noisy_blue[..., 2] + rng.normal(0, 12, ROWS.shape), 0, 255)
    content = gradient_content(noisy_blue, 255.0)
    assert best_channel([content])[0] == "luma"


def test_both_pictures_decide():
    """Red is a little better in one and much worse in the other."""
    one, other = (gradient_content(colours(a), 255.0) for a in ((60, 15, 15), (2, 20, 20)))
    assert best_channel([one])[0] == "red"
    assert best_channel([one, other])[0] == "luma"


def test_grey_pictures_stay_grey():
    assert best_channel([(), (1.0, 1.0, 1.0, 1.0)]) == ("luma", "not all pictures have colours")
    assert_array_equal(gradient_content(np.full((60, 60, 3), 7, np.uint8), 255.0), 0)
