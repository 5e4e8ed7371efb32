import numpy as np
import pytest

from shapemorph.core.forming import LimitCurve
from shapemorph.methods.forming.limits import caveats, limit_margin, margin_noise

CURVE = LimitCurve(
    np.array([-0.2, 0.0, 0.4]),
    np.array([0.5, 0.3, 0.5]),
    {"material": "AA 5083", "thickness_mm": "1.35", "temperature (C)": "500"},
)


def test_margin_is_what_is_left_below_the_curve():
    minor, major = np.array([-0.1, 0.0, 0.2, 0.2]), np.array([0.1, 0.3, 0.1, 0.6])
    np.testing.assert_allclose(limit_margin(CURVE, minor, major), [0.3, 0.0, 0.3, -0.2])


def test_the_curve_says_nothing_beyond_its_ends():
    found = limit_margin(CURVE, np.array([-0.3, 0.41, np.nan]), np.array([0.1, 0.1, 0.1]))
    assert np.isnan(found).all()


def test_noise_of_the_margin_is_that_of_drawn_strains():
    rng = np.random.default_rng(4)
    covariance = np.array([[4.0, 1.5], [1.5, 2.0]]) * 1e-6
    drawn = rng.multivariate_normal([0.2, 0.1], covariance, 200_000)
    sums = np.sqrt(covariance.sum())
    noise = (np.full(1, 2e-3), np.full(1, np.sqrt(2e-6)), np.full(1, sums))
    found = margin_noise(CURVE, np.full(1, 0.1), noise)
    scatter = limit_margin(CURVE, drawn[:, 1], drawn[:, 0]).std()
    np.testing.assert_allclose(found, scatter, rtol=0.01)


def test_there_is_no_noise_where_there_is_no_margin():
    minor = np.array([-0.21, -0.2, 0.0, 0.4, 0.41, np.nan])
    noise = (np.full(6, 0.01),) * 3
    missing = np.isnan(margin_noise(CURVE, minor, noise))
    np.testing.assert_array_equal(missing, np.isnan(limit_margin(CURVE, minor, np.zeros(6))))


def test_no_caveat_where_all_conditions_agree():
    assert caveats(CURVE, material="aa5083", thickness=1.4, temperature=505.0) == ()


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"material": "DC04"}, "material: the curve is for AA 5083, the specimen has DC04"),
        ({"thickness": 0.8}, "thickness: the curve is for 1.35, the specimen has 0.8 mm"),
        ({"temperature": 20.0}, "temperature: the curve is for 500, the specimen has 20 C"),
        ({"temperature": None}, "the temperature of the specimen is not known"),
    ],
)
def test_each_condition_that_differs_is_a_caveat(changed, words):
    specimen = {"material": "AA5083", "thickness": 1.35, "temperature": 500.0} | changed
    assert caveats(CURVE, **specimen) == (words,)


def test_a_curve_without_conditions_is_doubted_thrice():
    bare = LimitCurve(CURVE.minor, CURVE.major, {})
    found = caveats(bare, material=None, thickness=1.0, temperature=None)
    assert found == (
        "the material of the curve and of the specimen is not known",
        "the thickness of the curve is not known",
        "the temperature of the curve and of the specimen is not known",
    )
