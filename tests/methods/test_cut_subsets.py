"""Subsets that a rim cuts, counted and worked out on paper."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.core.image import GreyImage
from shapemorph.methods.cut_subsets import cut_noise, inside_share
from shapemorph.methods.grid_correlation import empty_matches
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import PointGrid


def test_the_worse_side_counts():
    grey = np.zeros((40, 50), dtype="f4")
    left, right = np.zeros((2, 40, 50), dtype=bool)
    left[:, 9:], right[:, :31] = True, True  # columns 10 ... 48 and 1 ... 29 count
    reference = prepare_reference(GreyImage(grey, left), allowed=None, pad=12)
    deformed = prepare_deformed(GreyImage(grey, right), pad=12)
    points = np.array([[[10, 20], [20, 20], [28, 20]]])
    grid = PointGrid(points, np.ones((1, 3), dtype=bool), 8)
    share = inside_share(reference, deformed, grid, empty_matches(grid), radius=5)
    assert_allclose(share, [[6 / 11, 1.0, 7 / 11]])


@pytest.mark.parametrize("share", [0.5, 0.7, 0.9, 1.0])
def test_the_random_error_is_that_of_a_line_at_the_middle_of_the_whole(share):
    wide, number = 1.0, 20001
    cut = np.linspace(0, share * wide, round(share * number))
    terms = np.stack([np.ones_like(cut), cut - 0.5 * wide], axis=1)
    variance = np.linalg.inv(terms.T @ terms)[0, 0] * number  # a whole width has 1
    assert_allclose(cut_noise(np.array(share)), np.sqrt(variance), rtol=1e-3)
