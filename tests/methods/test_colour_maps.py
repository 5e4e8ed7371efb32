import matplotlib as mpl
import numpy as np
import pytest

from shapemorph.methods.colour_maps import colour_table, colours_of

XYZ_FROM_RGB = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)
DEUTERANOPE = np.array(  # Machado, Oliveira and Fernandes 2009, severity 1, of linear RGB
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
     [-0.011820, 0.042940, 0.968881]]
)  # fmt: skip
PROTANOPE = np.array(
    [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
     [-0.003882, -0.048116, 1.051998]]
)  # fmt: skip


def _linear(table):
    encoded = table / 255
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def _lab(linear):
    """CIELAB of linear RGB, D65: another space than the map was made in."""
    share = linear @ XYZ_FROM_RGB.T / [0.9505, 1.0, 1.089]
    f = np.where(share > 0.008856, np.cbrt(share), 7.787 * share + 16 / 116)
    return np.stack(
        [116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1
    )


@pytest.mark.parametrize("name", ["viridis", "blue-red"])
def test_equal_steps_of_the_value_look_equally_large(name):
    lab = _lab(_linear(colour_table(name)))
    steps = np.linalg.norm(lab[8:] - lab[:-8], axis=1)  # of 8, for 8-bit rounding
    assert steps.std() < 0.25 * steps.mean()


def test_lightness_of_the_diverging_map_falls_alike_on_both_sides():
    lightness = _lab(_linear(colour_table("blue-red")))[:, 0]
    assert np.all(np.diff(lightness[:128]) > -0.3)
    assert np.all(np.diff(lightness[128:]) < 0.3)
    np.testing.assert_allclose(lightness[:128], lightness[:127:-1], atol=5)
    assert lightness.max() < 94  # not taken for paper


@pytest.mark.parametrize("vision", [np.eye(3), DEUTERANOPE, PROTANOPE])
def test_ends_of_the_diverging_map_differ_for_everybody(vision):
    seen = _lab(np.clip(_linear(colour_table("blue-red")) @ vision.T, 0, 1))
    assert np.linalg.norm(seen[0] - seen[-1]) > 45
    assert np.linalg.norm(seen[64] - seen[191]) > 25


def test_viridis_is_that_of_matplotlib():
    exact = mpl.colormaps["viridis"](np.arange(256))[:, :3]
    assert np.abs(colours_of("viridis") - exact).max() < 0.2 / 255
    assert np.abs(colour_table("viridis") - 255 * exact).max() <= 0.2 + 0.5  # and rounding


def test_other_maps_are_refused():
    with pytest.raises(ValueError, match="expected viridis or blue-red, got 'jet'"):
        colour_table("jet")
