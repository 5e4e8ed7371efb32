import numpy as np
import pytest

from shapemorph.methods.contrast import Pattern
from shapemorph.methods.repetition import find_repeat
from shapemorph.methods.synthetic.planar import planar_speckle
from shapemorph.methods.synthetic.planar_textures import cloudy, printed_dots, wood


def pattern(texture, turn=0.3, shape=(300, 380)):
    rows, cols = np.mgrid[: shape[0], : shape[1]].astype(np.float64)
    points = np.stack([cols, rows], -1) @ np.array(
        [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]
    )
    values = texture.at(points).astype(np.float32)
    return Pattern(values - values.mean(), np.hypot(rows - 150, cols - 180) < 145, 0.2)


def test_grid_of_dots_is_found_to_repeat_with_its_pitch_or_diagonal():
    found = find_repeat(pattern(printed_dots(pitch=16, other=None, share=0.0)), std=2.2)
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    steps = turn @ found / 16.0
    for candidate in (steps, turn.T @ found / 16.0):
        if np.abs(candidate - np.rint(candidate)).max() < 0.08:
            break
    else:
        pytest.fail(f"{found} is no whole number of steps of the grid")


@pytest.mark.parametrize("texture", [planar_speckle(diameter=5, seed=1), wood(width=4, seed=1)])
def test_what_is_random_does_not_repeat(texture):
    assert find_repeat(pattern(texture), std=1.6) is None


def test_faint_dots_under_another_pattern_still_repeat():
    mixed = printed_dots(pitch=16, other=cloudy(width=4, seed=1), share=0.3)
    assert find_repeat(pattern(mixed), std=2.2) is not None
