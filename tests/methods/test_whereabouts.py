import numpy as np

from shapemorph.methods.whereabouts import whereabouts


def test_ring_is_called_a_ring_with_its_radii():
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    circle = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    text = whereabouts(np.vstack([25 * circle, 35 * circle]) + np.array([100, 50, 0]))
    assert "ring around (100, 50, 0) mm between r = 25 and 35 mm" in text


def test_patch_is_described_by_centre_and_extent():
    x, y = np.meshgrid(np.linspace(0, 8, 9), np.linspace(0, 4, 5))
    text = whereabouts(np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3))
    assert text == "around (4, 2, 0) mm, extent 8 x 4 x 0 mm"
