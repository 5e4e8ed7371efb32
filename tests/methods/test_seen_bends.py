"""What subsets make of bending, worked out pixel by pixel and on paper."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shapemorph.core.image import GreyImage
from shapemorph.methods.matched_subsets import MatchedSubsets
from shapemorph.methods.seen_bends import seen_bends
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import identity_starts

RADIUS = 5


def _seen(order):
    grey, mask = np.zeros((40, 50), dtype="f4"), np.zeros((40, 50), dtype=bool)
    mask[:, 9:] = True  # columns 10 ... 48 count
    picture, pad = GreyImage(grey, mask), RADIUS + 10
    reference = prepare_reference(picture, allowed=None, pad=pad)
    deformed = prepare_deformed(picture, pad=pad)
    points = np.array([[[11, 20], [25, 20]]])
    cut = np.array([[True, False]])
    warps = identity_starts(2).reshape(1, 2, 12)
    subsets = MatchedSubsets.at((reference, deformed), points, warps, cut, RADIUS)
    return seen_bends(subsets, cut, order=order)[0]


@pytest.mark.parametrize("order", [0, 1])
def test_a_cut_subset_sees_what_a_fit_over_its_pixels_has_at_the_centre(order):
    x, y = (part.ravel() for part in np.meshgrid(np.arange(-1.0, 6), np.arange(-5.0, 6)))
    followed = np.column_stack([np.ones_like(x), x, y][: 1 if order == 0 else 3])
    bent = np.column_stack([x * x, x * y, y * y])
    expected = (np.linalg.pinv(followed) @ bent)[0]
    assert_allclose(_seen(order)[0], expected, atol=1e-4)  # single precision


def test_a_whole_subset_sees_the_mean_of_the_squares():
    assert_allclose(_seen(1)[1], [10.0, 0.0, 10.0])  # (11^2 - 1) / 12


def test_second_order_follows_bending():
    assert_allclose(_seen(2), 0.0)
