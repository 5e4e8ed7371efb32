import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from shapemorph.methods.speckle import choose_tiles, speckle_size, tile_widths


def noise(shape, sigma, seed=0):
    """Gaussian noise; half width of its autocorrelation: 2 sqrt(ln 2) sqrt(2) sigma... twice."""
    smooth = gaussian_filter(np.random.default_rng(seed).standard_normal(shape), sigma, mode="wrap")
    return (0.5 + 0.12 * smooth / smooth.std()).astype(np.float32)


def full_width(sigma):
    """Autocorrelation exp(-r^2 / (4 sigma^2)) is one half at r = 2 sigma sqrt(ln 2)."""
    return 4 * np.sqrt(np.log(2)) * sigma


@pytest.mark.parametrize("sigma", [0.9, 1.5, 3.0, 8.0, 15.0])
def test_size_is_the_width_of_the_autocorrelation_at_half_height(sigma):
    picture = noise((600, 900), sigma)
    everywhere = np.ones(picture.shape, dtype=bool)
    # a tile of 64 px holds few speckles: its own mean takes a few per cent off
    assert speckle_size(picture, everywhere) == pytest.approx(full_width(sigma), rel=0.1)


def test_a_stretched_speckle_counts_by_its_area():
    picture = noise((500, 700), (1.5, 3.0))
    everywhere = np.ones(picture.shape, dtype=bool)
    expected = full_width(np.sqrt(1.5 * 3.0))
    assert speckle_size(picture, everywhere) == pytest.approx(expected, rel=0.08)


def test_light_does_not_change_the_size():
    picture = noise((400, 500), 2.0)
    everywhere = np.ones(picture.shape, dtype=bool)
    slope = np.linspace(-0.1, 0.1, 500, dtype=np.float32)
    shaded = 0.6 * picture + slope + 0.1
    assert speckle_size(shaded, everywhere) == pytest.approx(
        speckle_size(picture, everywhere), rel=0.03
    )


def test_what_lies_outside_the_mask_does_not_matter():
    picture = noise((400, 500), 2.0)
    mask = np.hypot(*np.mgrid[-200:200, -250:250]) < 180
    spoilt = np.where(mask, picture, np.random.default_rng(5).random(picture.shape) * 40)
    assert speckle_size(spoilt.astype(np.float32), mask) == speckle_size(picture, mask)
    assert speckle_size(picture, mask) == pytest.approx(full_width(2.0), rel=0.08)


def test_a_blank_picture_has_no_speckle():
    blank = np.full((200, 300), 0.4, np.float32)
    assert np.isnan(speckle_size(blank, np.ones(blank.shape, dtype=bool)))


def test_too_small_a_picture_has_no_speckle():
    picture = noise((40, 300), 2.0)
    assert np.isnan(speckle_size(picture, np.ones(picture.shape, dtype=bool)))


def test_tiles_lie_inside_the_mask_and_are_few():
    mask = np.zeros((700, 900), dtype=bool)
    mask[100:600, 300:800] = True
    tiles = choose_tiles(mask)
    assert 20 < len(tiles) <= 36
    for row, col in tiles:
        assert mask[row : row + 64, col : col + 64].mean() >= 0.7
    assert len(choose_tiles(np.zeros((100, 100), dtype=bool))) == 0


def test_widths_are_measured_tile_by_tile():
    left, right = noise((200, 300), 1.2, 1), noise((200, 300), 3.0, 2)
    picture = np.hstack([left, right])
    tiles = np.array([[60, 40], [60, 400]])
    widths = tile_widths(picture, np.ones(picture.shape, dtype=bool), tiles)
    np.testing.assert_allclose(widths, [full_width(1.2), full_width(3.0)], rtol=0.2)
