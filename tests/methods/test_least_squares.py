import numpy as np

from shapemorph.methods.least_squares import fit_operators


def test_operators_agree_with_a_solver_that_knows_nothing_of_them():
    rng = np.random.default_rng(4)
    terms = rng.normal(size=(6, 12, 4))
    inside = rng.random((6, 12)) > 0.2
    data = rng.normal(size=(6, 12))
    operators = fit_operators(terms, inside, worst_condition=1e6)
    for k in range(6):
        expected, *_ = np.linalg.lstsq(terms[k][inside[k]], data[k][inside[k]], rcond=None)
        np.testing.assert_allclose(operators[k] @ data[k], expected, atol=1e-10)


def test_points_that_do_not_settle_the_coefficients_give_nan_and_spare_the_others():
    terms = np.ones((2, 5, 2))
    terms[1, :, 1] = np.arange(5)
    operators = fit_operators(terms, np.ones((2, 5), dtype=bool), worst_condition=1e6)
    assert np.isnan(operators[0]).all()
    assert np.isfinite(operators[1]).all()
