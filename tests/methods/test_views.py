import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.ndimage import gaussian_filter

from shapemorph.methods.contrast import Pattern
from shapemorph.methods.speckle_ellipse import measure_speckle
from shapemorph.methods.views import is_uniform, round_views, rounding

SHAPE = (620, 800)


def pattern(std_y, std_x, seed=0, shape=SHAPE):
    noise = np.random.default_rng(seed).normal(size=shape)
    values = gaussian_filter(noise, (std_y, std_x))
    return Pattern((values / values.std()).astype(np.float32), np.ones(shape, bool), 0.2)


def varying():
    fine, long = pattern(1.5, 1.5), pattern(1.5, 4.0, seed=1)
    values = np.where(np.arange(SHAPE[1]) < 400, fine.values, long.values)
    return Pattern(values, fine.mask, 0.2)


def test_rounding_makes_an_ellipse_a_circle_of_the_wanted_size():
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    covariance = turn @ np.diag([9.0, 1.0]) @ turn.T
    logarithm = turn @ np.diag(np.log([9.0, 1.0])) @ turn.T
    matrix = rounding(logarithm, 1.6)
    assert_allclose(matrix @ covariance @ matrix.T, 1.6**2 * np.eye(2), atol=1e-12)
    assert np.linalg.det(matrix) > 0


def test_speckle_is_round_in_the_view():
    stretched = pattern(1.5, 4.5)
    (view,) = round_views(stretched, measure_speckle(stretched, window=150), std=2.0)
    seen = Pattern((view.grey.astype(np.float32) - 128) / 40, view.mask, 0.2)
    eigenvalues = np.linalg.eigvalsh(measure_speckle(seen, window=150).median)
    assert_allclose(np.exp(0.5 * eigenvalues), [2.0, 2.0], rtol=0.12)


def test_view_shows_the_picture_where_its_matrix_says():
    stretched = pattern(3.0, 3.0)
    (view,) = round_views(stretched, measure_speckle(stretched, window=150), std=3.0)
    rows, cols = np.nonzero(view.mask)
    pick = slice(None, None, 997)
    inside = np.column_stack([cols, rows])[pick] - view.matrix[:, 2]
    x, y = np.linalg.solve(view.matrix[:, :2], inside.T)
    sampled = stretched.values[np.rint(y).astype(int), np.rint(x).astype(int)]
    shown = (view.grey[rows[pick], cols[pick]].astype(float) - 128) / 40
    # sampled at the nearest pixel: half a pixel against a speckle of 3
    assert np.corrcoef(sampled, shown)[0, 1] > 0.97


def test_tiles_cover_every_pixel_once_where_the_speckle_varies():
    picture = varying()
    field = measure_speckle(picture, window=80)
    assert not is_uniform(field)
    assert is_uniform(measure_speckle(pattern(1.5, 4.0), window=80))
    views = round_views(picture, field, std=2.0)
    assert len(views) >= 4
    points = np.random.default_rng(0).uniform([5, 5], [794, 614], (400, 2))
    seen = np.zeros(400)
    for view in views:
        place = np.rint(points @ view.matrix[:, :2].T + view.matrix[:, 2]).astype(int)
        inside = (place >= 0).all(1) & (place < np.array(view.mask.shape[::-1])).all(1)
        seen[inside] += view.mask[place[inside, 1], place[inside, 0]]
    assert (seen == 1).mean() > 0.95  # outlines are drawn to the pixel
    assert seen.min() >= 1


@pytest.mark.parametrize("part", [np.s_[:, :390], np.s_[:200]])
def test_views_of_nothing_are_left_out(part):
    picture = varying()
    mask = np.zeros(SHAPE, bool)
    mask[part] = True
    field = measure_speckle(picture, window=80)
    every = len(round_views(picture, field, std=2.0))
    some = round_views(Pattern(picture.values, mask, 0.2), field, std=2.0)
    assert 0 < len(some) < every
