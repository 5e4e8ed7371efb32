import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import gaussian_filter, map_coordinates

from shapemorph.kernels.zncc import resample_through, search
from shapemorph.methods.spline_sampling import sample_vectors

RNG = np.random.default_rng(0)
PICTURE = (10 * gaussian_filter(RNG.normal(size=(90, 120)), 2.0)).astype(np.float32)
ONES = np.ones_like(PICTURE)
POINTS = np.array([[40, 30], [61, 47], [88, 52]], np.int64)


def shifted(dx, dy):
    """The picture moved by (dx, dy), from its cubic spline."""
    rows, cols = np.mgrid[:90, :120]
    return map_coordinates(PICTURE, [rows - dy, cols - dx], mode="mirror").astype(np.float32)


def found(moved, mask=ONES, moved_mask=ONES, points=POINTS, radius=6, least=0.5):
    return search(
        PICTURE * mask, mask, moved * moved_mask, moved_mask, points, 10, radius, 2, least
    )


@pytest.mark.parametrize(("dx", "dy"), [(0.0, 0.0), (3.0, -4.0), (-2.4, 1.3), (0.5, 4.6)])
def test_shift_is_found_to_a_few_hundredths(dx, dy):
    result = found(shifted(dx, dy))
    assert_allclose(result[:, :2], np.tile([dx, dy], (3, 1)), atol=0.06)
    assert (result[:, 2] > 0.95).all()


def test_likeness_is_that_of_the_textbook():
    moved = (PICTURE + RNG.normal(size=PICTURE.shape)).astype(np.float32)
    dx, dy, score = found(moved)[1]
    assert max(abs(dx), abs(dy)) < 0.5
    window = np.s_[37:58, 51:72]
    assert_allclose(
        score, np.corrcoef(PICTURE[window].ravel(), moved[window].ravel())[0, 1], rtol=1e-4
    )


def test_gain_and_offset_do_not_matter():
    assert_allclose(found(0.3 * shifted(1.2, 2.0) + 5), found(shifted(1.2, 2.0)), atol=2e-3)


def test_what_the_masks_hide_does_not_count():
    mask, moved_mask = ONES.copy(), ONES.copy()
    mask[:, 45:], moved_mask[:28] = 0, 0
    nonsense = shifted(1.0, -1.0)
    nonsense[:28] = 50 * RNG.normal(size=(28, 120))
    result = found(nonsense, mask, moved_mask, points=POINTS[:1], least=0.3)
    assert_allclose(result[0, :2], [1.0, -1.0], atol=0.1)
    assert result[0, 2] > 0.99


def test_too_little_in_view_is_not_found():
    mask = ONES.copy()
    mask[:, 38:] = 0
    assert np.isnan(found(shifted(1.0, 0.0), mask)).all()


def test_best_at_the_edge_of_the_search_is_not_found():
    assert np.isnan(found(shifted(7.0, 0.0), points=POINTS[:1], radius=4)[0]).all()


def test_blank_window_is_not_found():
    assert np.isnan(found(np.zeros_like(PICTURE))).all()


def test_warped_picture_is_that_of_scipy():
    coefficients = np.stack(np.meshgrid(np.arange(9.0), np.arange(8.0)), -1) * 20 - 15
    coefficients += RNG.normal(size=coefficients.shape)
    origin, spacing = np.array([-21.0, -19.0]), 19.0
    mask = np.ones(PICTURE.shape, bool)
    mask[40:, 70:] = False
    values, visible = resample_through(coefficients, origin, spacing, PICTURE, mask, 50, 55, 0.5)
    rows, cols = np.mgrid[:50, :55]
    source = np.stack([cols, rows], -1).reshape(-1, 2) * 2 + 0.5
    u, v = sample_vectors(coefficients, (source - origin) / spacing)[0].T
    expected = map_coordinates(PICTURE, [v, u], order=1, cval=np.nan).reshape(50, 55)
    seen = visible > 0
    assert 1000 < seen.sum() < seen.size
    assert_allclose(values[seen], expected[seen], atol=1e-4)
    assert not values[~seen].any()
    hidden = (np.floor(v) >= 40) & (np.floor(u) >= 70)
    assert not seen.ravel()[hidden].any()
