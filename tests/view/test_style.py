import numpy as np
import pytest

from shapemorph.core.status import PointStatus
from shapemorph.view.style import STATUS_COLOURS, STATUS_WORDS, colour_scale, reduced, round_length


def test_scale_is_centred_on_zero_where_both_signs_matter():
    scale = colour_scale(np.linspace(-3, 1, 2001))
    assert scale.name == "blue-red"
    assert scale.low == -scale.high
    assert scale.high == pytest.approx(2.98, abs=0.01)


def test_few_negative_values_do_not_make_a_magnitude_diverge():
    values = np.linspace(-0.02, 1, 1001)
    assert colour_scale(values).name == "viridis"


def test_arrows_stand_where_values_lie_beyond():
    values = np.concatenate([np.linspace(1, 2, 2000), [50.0]])
    assert colour_scale(values).high < 2.01
    assert colour_scale(values).beyond == "both"
    assert colour_scale(np.linspace(1, 2, 2000), np.array([1.5, 0.2])).beyond == "min"


def test_constant_and_missing_values_still_have_a_scale():
    for values in (np.full(9, 7.0), np.zeros(4), np.full(5, np.nan)):
        scale = colour_scale(values)
        assert scale.low < scale.high


def test_missing_is_grey_and_extremes_are_the_ends_of_the_map():
    scale = colour_scale(np.linspace(0, 1, 1001))
    colours = scale.colours(np.array([-5.0, 9.0, np.nan])).astype(int)
    assert np.ptp(colours[2]) < 20
    assert colours[1, 0] > 240  # the yellow end of viridis
    assert colours[1, 2] < 100
    assert colours[0].max() < 90  # dark end


@pytest.mark.parametrize(("longest", "length"), [(0.7, 0.5), (1.0, 1.0), (4.99, 2.0), (730, 500)])
def test_scale_bars_have_round_lengths(longest, length):
    assert round_length(longest) == pytest.approx(length)


def test_every_status_has_its_own_colour_and_word():
    assert set(STATUS_COLOURS) == set(STATUS_WORDS) == set(PointStatus)
    assert len(set(STATUS_COLOURS.values())) == len(PointStatus)


def test_reduced_picture_averages_whole_blocks():
    picture = np.random.default_rng(0).random((410, 30)).astype(np.float32)
    small = reduced(picture, 205)
    assert small.shape == (205, 15)
    assert small[3, 2] == pytest.approx(picture[6:8, 4:6].mean(), abs=1e-6)
    assert reduced(picture, 1000).shape == picture.shape


def test_nothing_does_not_look_like_much():
    values = np.random.default_rng(0).normal(scale=1e-4, size=2000)
    scale = colour_scale(values, least=0.2)
    assert (scale.low, scale.high) == (-0.1, 0.1)
    scale = colour_scale(1 + np.abs(values), least=0.1)
    assert scale.high == pytest.approx(scale.low + 0.1)
    assert colour_scale(1e4 * values, least=0.2).high > 2
