import numpy as np
import pytest

from shapemorph.view.rulers import Ruler, round_numbers
from shapemorph.view.style import INK, new_figure


@pytest.mark.parametrize(
    ("low", "high", "count", "words", "power"),
    [
        (0.0, 1.0, 5, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"], ""),
        (-0.5, 639.5, 5, ["0", "200", "400", "600"], ""),
        (-3.0, 3.0, 4, ["−2", "0", "2"], ""),
        (1e-7, 4.2e-7, 5, ["1", "2", "3", "4"], "1e−7"),
        (1000.001, 1000.0051, 3, ["1000.002", "1000.004"], ""),
    ],
)
def test_numbers_are_round_and_lie_between_the_ends(low, high, count, words, power):
    values, found, common = round_numbers(low, high, count)
    assert (found, common) == (words, power)
    factor = float(power.replace("−", "-")) if power else 1.0
    said = [float(word.replace("−", "-")) * factor for word in found]
    np.testing.assert_allclose(values, said, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("side", ["left", "right", "below"])
def test_ticks_stand_where_their_values_are(side):
    figure, box = new_figure(400, 300), (100.0, 50.0, 200.0, 150.0)
    reach = Ruler(side, 10.0, 0.0, 5, 10.0, INK).draw(figure, box)
    feet = np.array([line[0] for line in figure.artists[0].get_segments()]) * [400, 300]
    values = np.array([float(text.get_text()) for text in figure.texts])
    share = (10.0 - values) / 10.0
    across, down = feet[:, 0], 300 - feet[:, 1]
    if side == "below":
        np.testing.assert_allclose(across, 100 + 200 * share)
        np.testing.assert_allclose(down, 200)
    else:
        np.testing.assert_allclose(across, 100 if side == "left" else 300)
        np.testing.assert_allclose(down, 50 + 150 * share)
    boxes = [text.get_window_extent() for text in figure.texts]
    outermost = {
        "left": 100 - min(b.x0 for b in boxes),
        "right": max(b.x1 for b in boxes) - 300,
        "below": 100 - min(b.y0 for b in boxes),
    }[side]
    assert outermost == pytest.approx(reach, abs=2)


def test_a_common_power_is_written_once():
    figure = new_figure(300, 300)
    Ruler("right", 4e-7, 0.0, 5, 10.0, INK).draw(figure, (50.0, 50.0, 20.0, 200.0))
    assert [text.get_text() for text in figure.texts][-1] == "1e−7"
