import numpy as np
import pytest
from scipy.ndimage import spline_filter

from shapemorph.kernels.pyramid import reduce_by_two
from shapemorph.kernels.texture import resample
from shapemorph.methods import spline_coefficients


def to_coefficients(picture, repeats, degree=3):
    coefficients = picture.copy()
    spline_coefficients.to_coefficients(coefficients, repeats, degree=degree)
    return coefficients


@pytest.mark.parametrize(("repeats", "mode"), [(0, "mirror"), (1, "grid-wrap")])
@pytest.mark.parametrize("shape", [(37, 53), (128, 20), (2, 5)])
@pytest.mark.parametrize(("degree", "off"), [(3, 2e-6), (5, 1e-5)])  # float32
def test_coefficients_are_those_of_the_interpolating_spline(repeats, mode, shape, degree, off):
    picture = np.random.default_rng(0).random(shape, dtype=np.float32)
    expected = spline_filter(picture.astype(np.float64), order=degree, mode=mode)
    np.testing.assert_allclose(to_coefficients(picture, repeats, degree), expected, atol=off)


def test_a_picture_of_one_row_keeps_its_height():
    picture = np.random.default_rng(1).random((1, 40), dtype=np.float32)
    expected = spline_filter(picture[0].astype(np.float64), order=3, mode="mirror")
    np.testing.assert_allclose(to_coefficients(picture, 0)[0], expected, atol=2e-6)


def test_halving_averages_boxes_and_repeats_an_odd_end():
    picture = np.arange(15, dtype=np.float32).reshape(3, 5)
    expected = np.array([[3, 5, 6.5], [10.5, 12.5, 14]], dtype=np.float32)
    np.testing.assert_array_equal(reduce_by_two(picture), expected)


def _table(*levels):
    offsets = np.cumsum([0] + [level.size for level in levels[:-1]])
    rows = [(start, *level.shape) for start, level in zip(offsets, levels, strict=True)]
    return np.concatenate([level.ravel() for level in levels]), np.array(rows)


def test_resampling_at_pixel_centres_gives_the_picture_back():
    picture = np.random.default_rng(3).random((21, 34), dtype=np.float32)
    texels, table = _table(to_coefficients(picture, 0))
    rows, cols = np.mgrid[0:21, 0:34]
    points = np.stack([cols.ravel(), rows.ravel()], axis=1).astype(np.float64)
    frames = np.broadcast_to(np.eye(2), (len(points), 2, 2)).copy()
    found = resample(points, frames, texels, table).reshape(21, 34)
    np.testing.assert_allclose(found, picture, atol=2e-6)


def test_resampling_averages_over_the_footprint():
    rows, cols = np.mgrid[0:64, 0:64]
    stripes = ((cols + rows) % 2).astype(np.float32)  # as fine as a picture can be
    levels = [stripes]
    for _ in range(3):
        levels.append(reduce_by_two(levels[-1]))
    texels, table = _table(*(to_coefficients(level, 0) for level in levels))
    points = np.random.default_rng(4).uniform(20, 44, (200, 2))
    for stretch in (4.0, 6.0, 13.0):
        frames = np.broadcast_to(stretch * np.eye(2), (200, 2, 2)).copy()
        assert np.abs(resample(points, frames, texels, table) - 0.5).max() < 0.06


@pytest.mark.parametrize("turn", [0.0, 0.4, 0.8, 2.0])
def test_a_long_narrow_footprint_keeps_what_lies_across_it(turn):
    along = np.array([np.cos(0.5), np.sin(0.5)])
    across = np.array([-along[1], along[0]])
    rows, cols = np.mgrid[0:160, 0:160]
    wave = 2 * np.pi / 7.2  # a period is six footprints of 1.2 px wide
    picture = 0.5 + 0.4 * np.cos(wave * (cols * across[0] + rows * across[1]))
    levels = [picture.astype(np.float32)]
    for _ in range(4):
        levels.append(reduce_by_two(levels[-1]))
    texels, table = _table(*(to_coefficients(level, 0) for level in levels))
    points = np.random.default_rng(5).uniform(30, 130, (300, 2))
    cos, sin = np.cos(turn), np.sin(turn)
    frame = np.stack([9.6 * along, 1.2 * across], axis=1) @ [[cos, -sin], [sin, cos]]
    frames = np.broadcast_to(frame, (300, 2, 2)).copy()
    shown = np.cos(wave * points @ across)
    kept = (resample(points, frames, texels, table) - 0.5) @ shown / (0.4 * shown @ shown)
    assert 0.95 < kept < 1.0  # exp(-(2 pi / 6)^2 / 24) for a box, 1 for a point


def test_beyond_the_picture_there_is_no_value():
    texels, table = _table(to_coefficients(np.ones((8, 10), np.float32), 0))
    points = np.array([[-0.51, 3.0], [9.51, 3.0], [3.0, 7.51], [np.nan, 1.0], [9.5, 7.5]])
    frames = np.broadcast_to(np.eye(2), (5, 2, 2)).copy()
    np.testing.assert_array_equal(
        np.isfinite(resample(points, frames, texels, table)), [0, 0, 0, 0, 1]
    )
