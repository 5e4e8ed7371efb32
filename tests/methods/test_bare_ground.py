import numpy as np
import pytest

from shapemorph.core.image import GreyImage
from shapemorph.methods.bare_ground import without_ground

SHAPE = (320, 448)


@pytest.fixture
def scene(wave_pattern, pixel_grid):
    pixels = pixel_grid(SHAPE)
    grey = wave_pattern(6.0)(pixels)
    return np.hypot(pixels[..., 0] - 200, pixels[..., 1] - 150) < 120, grey


def seen_by_a_camera(grey, noise):
    noisy = grey + np.random.default_rng(5).normal(0, noise, grey.shape)
    levels = np.rint(255 * np.clip(noisy, 0, 1)).astype(np.float32)
    return GreyImage(levels / np.float32(255), np.ones(grey.shape, dtype=bool))


@pytest.mark.parametrize(
    ("noise", "slope"), [(0.0, 0.0), (1.5 / 255, 0.0), (1.5 / 255, 0.3 / 448), (4.0 / 255, 0.0)]
)
def test_a_specimen_is_told_from_the_ground(scene, noise, slope):
    disc, grey = scene
    light = 0.2 + slope * np.arange(SHAPE[1])
    picture = seen_by_a_camera(np.where(disc, grey, light), noise)
    found = without_ground(picture)
    assert found.mask[disc].mean() > 0.995  # slivers of tiles may go
    assert found.mask.sum() < 1.5 * disc.sum()
    assert found.grey is picture.grey


def test_a_pattern_all_over_stays_whole(scene):
    _, grey = scene
    picture = seen_by_a_camera(grey, 1.5 / 255)
    assert without_ground(picture) is picture


def test_a_pattern_that_is_faint_in_the_shade_is_pattern(scene):
    disc, grey = scene
    picture = seen_by_a_camera(np.where(disc, grey, 0.1 * grey), 0.5 / 255)
    assert without_ground(picture) is picture


def test_nothing_but_ground_stays_as_it_is():
    picture = seen_by_a_camera(np.full(SHAPE, 0.4), 2.0 / 255)
    assert without_ground(picture) is picture
    empty = GreyImage(picture.grey, np.zeros(SHAPE, dtype=bool))
    assert without_ground(empty) is empty
