import numpy as np
from numpy.testing import assert_allclose

from shapemorph.kernels.local_fit import fit_locally

RNG = np.random.default_rng(0)
SOURCE = RNG.uniform(-50, 50, (40, 2))
QUERY = np.array([[3.0, -7.0]])
EVERYONE = np.argsort(np.linalg.norm(SOURCE - QUERY, axis=1))[None].astype(np.int64)
NO_SIDE = np.zeros((1, 2))


def linear(points):
    return points @ np.array([[2.0, 0.3], [-0.5, 0.8]]) + np.array([10.0, -4.0])


def test_plane_is_found_exactly_with_its_gradient():
    prediction, gradient, spread = fit_locally(
        SOURCE, linear(SOURCE), EVERYONE, QUERY, NO_SIDE, 40, 3, 0.1
    )
    assert_allclose(prediction, linear(QUERY), atol=1e-3)  # the fit is regularised by 1e-6
    assert_allclose(gradient[0], np.array([[2.0, -0.5], [0.3, 0.8]]), atol=1e-5)
    assert spread[0] < 1e-3


def test_quadratic_surface_follows_a_curvature_that_a_plane_misses():
    target = linear(SOURCE) + 0.004 * SOURCE**2
    expected = linear(QUERY) + 0.004 * QUERY**2
    errors = [
        np.linalg.norm(
            fit_locally(SOURCE, target, EVERYONE, QUERY, NO_SIDE, 40, terms, 0.1)[0] - expected
        )
        for terms in (3, 6)
    ]
    assert errors[1] < 0.3 * errors[0]  # the curved terms are held back a little
    assert errors[0] > 1


def test_third_of_wild_neighbours_changes_little():
    target = linear(SOURCE)
    target[::3] += RNG.uniform(20, 80, (14, 2))
    prediction, _gradient, _spread = fit_locally(
        SOURCE, target, EVERYONE, QUERY, NO_SIDE, 40, 3, 0.1
    )
    assert_allclose(prediction, linear(QUERY), atol=0.5)


def test_side_hears_only_one_side_of_a_kink():
    kinked = SOURCE + np.column_stack([np.maximum(SOURCE[:, 0] - 3.0, 0), np.zeros(40)])
    for side, slope in (([1.0, 0.0], 2.0), ([-1.0, 0.0], 1.0)):
        prediction, gradient, _spread = fit_locally(
            SOURCE, kinked, EVERYONE, QUERY, np.array([side]), 40, 3, 0.1
        )
        assert_allclose(prediction, QUERY, atol=1e-2)
        assert_allclose(gradient[0, 0, 0], slope, atol=1e-3)


def test_too_few_neighbours_give_nan():
    prediction, gradient, spread = fit_locally(
        SOURCE, SOURCE, EVERYONE[:, :5], QUERY, NO_SIDE, 40, 3, 0.1
    )
    assert np.isnan(prediction).all()
    assert np.isnan(gradient).all()
    assert np.isnan(spread).all()
