import numpy as np
import pytest

from shapemorph.view.colour_bar import ARROW, draw_colour_bar
from shapemorph.view.style import ColourScale, new_figure
from shapemorph.view.theme import THEMES, drawn

BOX = (40.0, 30.0, 20.0, 200.0)


@pytest.mark.parametrize(("theme", "ratio"), [("light", 1), ("print", 2)])
@pytest.mark.parametrize("beyond", ["neither", "min", "max", "both"])
def test_a_bar_has_the_colour_of_each_value_at_its_height(theme, ratio, beyond):
    figure, scale = new_figure(200, 260), ColourScale("viridis", -1.0, 3.0, beyond)
    draw_colour_bar(figure, BOX, scale, "E  [–]")
    pixels = drawn(figure, THEMES[theme]).astype(int)
    arrow = ARROW * 200
    top = 30 + (beyond in ("max", "both")) * arrow
    bottom = 230 - (beyond in ("min", "both")) * arrow
    values = np.linspace(-0.9, 2.9, 15)
    rows = (bottom + (values + 1.0) / 4.0 * (top - bottom)) * ratio
    seen = pixels[rows.astype(int), 50 * ratio]
    assert np.abs(seen - scale.colours(values)).max() <= 8
    paper = (pixels[:, 50 * ratio] == 255).all(axis=1)
    assert np.flatnonzero(~paper)[[0, -1]] == pytest.approx([30 * ratio, 230 * ratio - 1], abs=2)


def test_the_label_stands_beside_the_numbers():
    figure = new_figure(200, 260)
    draw_colour_bar(figure, BOX, ColourScale("viridis", 0.0, 1000.0, "neither"), "w  [mm]")
    *numbers, label = figure.texts
    assert label.get_text() == "w  [mm]"
    furthest = max(text.get_window_extent().x1 for text in numbers)
    left = label.get_window_extent().x0
    assert furthest + 5 < left < furthest + 15
