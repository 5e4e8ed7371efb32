"""Maps of least stretch: isometric where that is possible, injective where that is promised."""

import numpy as np
import pytest

from shapemorph.methods.distortion import singular_values
from shapemorph.methods.parametrize.arap import parametrise_arap
from shapemorph.methods.parametrize.boundary_first import parametrise_boundary_first
from shapemorph.methods.parametrize.slim import parametrise_slim

BOTH = [parametrise_arap, parametrise_slim]


@pytest.mark.parametrize("make", BOTH)
@pytest.mark.parametrize("scale", [1.2, 900.0])
def test_a_developable_patch_keeps_every_length(pipe, anywhere, make, scale):
    points, faces, _, _ = pipe(4.5)
    space = anywhere(points, scale)
    stretch = singular_values(space, faces, make(space, faces))
    # flat triangles of a pipe are themselves developable; the iterations stop at 1e-4, 1e-3
    np.testing.assert_allclose(stretch.sigma_1, 1.0, atol=1e-3)
    np.testing.assert_allclose(stretch.sigma_2, 1.0, atol=1e-3)


@pytest.mark.parametrize("make", BOTH)
def test_a_dome_is_stretched_more_evenly_than_by_a_conformal_map(ball_cap, anywhere, make):
    points, faces, _ = ball_cap(1.9, count=30)
    space = anywhere(points, 20.0)
    spans = []
    for each in (make, parametrise_boundary_first):
        stretch = singular_values(space, faces, each(space, faces))
        low, high = np.quantile(stretch.sigma_1 * stretch.sigma_2, [0.01, 0.99])
        spans.append(high / low)
    assert spans[0] < 0.5 * spans[1]


def test_slim_folds_nothing_on_a_rough_deep_pocket(ball_cap, anywhere):
    points, faces, _ = ball_cap(2.8, count=24)
    space = anywhere(points * [1.0, 0.6, 1.7], noise=0.02)
    assert singular_values(space, faces, parametrise_slim(space, faces)).flips == 0


def test_the_same_input_gives_the_same_bits(ball_cap):
    points, faces, _ = ball_cap(1.5, count=12)
    for make in BOTH:
        np.testing.assert_array_equal(make(points, faces), make(points, faces))
