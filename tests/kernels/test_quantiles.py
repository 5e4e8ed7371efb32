"""Weighted quantiles agree with a full sort."""

import numpy as np
import pytest

from shapemorph.kernels.quantiles import FEW, select_by_weight


def by_sorting(values, weights, share):
    known = np.isfinite(values) & (weights > 0)
    order = np.argsort(values[known], kind="stable")
    total = np.cumsum(weights[known][order])
    return values[known][order][np.searchsorted(total, share * total[-1])]


@pytest.mark.parametrize("share", [0.0, 0.01, 0.5, 0.99, 1.0])
@pytest.mark.parametrize("kind", ["even", "tailed", "steps"])
def test_the_value_is_that_of_a_full_sort(kind, share):
    random = np.random.default_rng(4)
    values = random.normal(size=5 * FEW)
    if kind == "tailed":
        values = np.exp(12 * values)
    if kind == "steps":
        values = np.round(values)
    values[::17] = np.nan
    weights = random.integers(0, 5, len(values)).astype(float)  # sums without round-off
    assert select_by_weight(values, weights, share) == by_sorting(values, weights, share)


def test_equal_values_and_no_values_end():
    assert select_by_weight(np.full(3 * FEW, 2.5), np.ones(3 * FEW), 0.3) == 2.5
    assert np.isnan(select_by_weight(np.full(3, np.nan), np.ones(3), 0.5))
    assert np.isnan(select_by_weight(np.ones(3), np.zeros(3), 0.5))
