"""The stages of image-morphing, from pictures that lie 4 px apart."""

import numpy as np
import pytest

from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Matches
from shapemorph.methods.warp_fit import fit_warp
from shapemorph.view.stages import stages_figure

SHIFT = np.array([4.0, -2.0])


def _shifted(source, shift):
    return fit_warp(
        source, source + shift, extent=(np.zeros(2), np.full(2, 99.0)), spacing=30.0, smoothing=1e-6
    )


@pytest.fixture
def axes():
    rng = np.random.default_rng(0)
    image = GreyImage(rng.random((100, 100), dtype=np.float32), np.ones((100, 100), np.bool_))
    masked = GreyImage(image.grey, np.hypot(*np.mgrid[-50:50, -50:50]) < 40)
    pairs = rng.uniform(20, 80, (60, 2))
    warps = _shifted(pairs, SHIFT), _shifted(pairs, -SHIFT)
    matches = Matches(pairs, pairs + SHIFT, *warps, {}, 0.0, 0.0, 0.0)
    grid = np.stack(np.meshgrid(np.arange(20.0, 80, 10), np.arange(20.0, 80, 10)), -1)
    middle = grid.reshape(-1, 2)
    grids = middle - SHIFT / 2, middle, middle, middle[:5] + SHIFT / 2
    figure = stages_figure((masked, image, image, image), matches, warps, grids)
    return [own for own in figure.axes if own.images or own.yaxis_inverted()]


def test_only_a_mask_that_leaves_something_out_has_an_outline(axes):
    (outline,) = axes[0].collections
    corners = np.concatenate([path.vertices for path in outline.get_paths()])
    np.testing.assert_allclose(np.hypot(*(corners - 50).T), 40, atol=1)
    assert not axes[1].collections


def test_disparities_are_shown_with_the_surfaces_through_them_both_ways(axes):
    panels = axes[2:8]
    for own, value in zip(panels, (4, -2, 4, -2, -4, 2), strict=True):
        np.testing.assert_allclose(own.collections[0].get_array(), value, atol=1e-3)
    assert len(panels[4].collections[0].get_offsets()) > len(panels[2].collections[0].get_offsets())


def test_the_grid_lies_on_both_pictures_in_the_middle_and_on_both_ends(axes):
    first, early, late, last = (own.lines[0].get_xydata() for own in axes[8:])
    np.testing.assert_allclose(early, late)
    np.testing.assert_allclose(first, early - SHIFT / 2)
    assert len(early) == 36
    assert len(last) == 5
