"""Fused sums over subsets against sums written out with scipy."""

import numpy as np
import pytest
from numba import njit
from numpy.testing import assert_allclose
from scipy.ndimage import map_coordinates

from shapemorph.kernels import subset_hessian, subset_rows

RADIUS, WIDTH = 6, 32


@njit
def warped_moments(*arguments):
    subset_rows.warped_moments(*arguments)


@njit
def reference_moments(*arguments):
    subset_hessian.reference_moments(*arguments)


@njit
def fill_hessian(*arguments):
    subset_hessian.fill_hessian(*arguments)


X, Y = 40, 31
LANE_X = (np.arange(WIDTH) - RADIUS).astype(np.float32)


def _pictures(seed=0):
    rng = np.random.default_rng(seed)
    return (
        rng.random((3, 64, 80)).astype(np.float32),
        rng.random((64, 80)).astype(np.float32),
    )


def _weights(holes=False):
    weights = np.zeros((2 * RADIUS + 1, WIDTH), dtype=np.float32)
    weights[:, : 2 * RADIUS + 1] = 1
    if holes:
        weights[:, : 2 * RADIUS + 1] = np.random.default_rng(5).random((13, 13)) > 0.3
    return weights


def _terms():
    y, x = np.mgrid[-RADIUS : RADIUS + 1, -RADIUS : RADIUS + 1].astype(float)
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y])


def _expected(reference, coefficients, warp, weights, mean, degree=3):
    terms = _terms()
    at_x, at_y = np.tensordot(warp[:6], terms, 1), np.tensordot(warp[6:], terms, 1)
    grey = map_coordinates(
        coefficients.astype(float), [Y + at_y, X + at_x], order=degree, prefilter=False
    )
    grey = (grey - mean) * weights[:, : 2 * RADIUS + 1]
    window = (slice(Y - RADIUS, Y + RADIUS + 1), slice(X - RADIUS, X + RADIUS + 1))
    own, slope_x, slope_y = reference[:, *window].astype(float)
    sums = [grey.sum(), (grey**2).sum(), (grey * own).sum()]
    sums += [(grey * slope_x * term).sum() for term in terms]
    return np.array(sums + [(grey * slope_y * term).sum() for term in terms])


WARPS = {
    "still": [0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0],
    "shifted": [0.4, 1, 0, 0, 0, 0, -2.7, 0, 1, 0, 0, 0],
    "hardly": [1e-3, 1.0005, -4e-4, 0, 0, 0, -2e-3, 3e-4, 0.9996, 0, 0, 0],
    "crossing": [0.45, 1.03, 0.04, 0, 0, 0, 0.3, -0.05, 0.96, 0, 0, 0],
    "stretched": [0.2, 1.18, -0.12, 0, 0, 0, 3.3, 0.15, 0.85, 0, 0, 0],
    "turned": [1.2, -0.4, 0.9, 0, 0, 0, 0.1, -1.1, -0.3, 0, 0, 0],
    "bent": [0.3, 1.02, 0.01, 0.004, -0.003, 0.002, 0.6, 0.0, 0.99, -0.005, 0.001, 0.004],
}


@pytest.mark.parametrize("name", WARPS)
@pytest.mark.parametrize(("holes", "degree"), [(False, 3), (True, 3), (True, 5)])
def test_warped_moments_are_the_sums_written_out(name, holes, degree):
    reference, coefficients = _pictures()
    weights, warp, moments = _weights(holes), np.array(WARPS[name], dtype=float), np.zeros(15)
    mean = np.float32(0.5)
    wide = None if degree == 3 else degree
    warped_moments(
        coefficients, wide, X, Y, warp, RADIUS, 1, reference, weights, LANE_X, mean, moments
    )
    expected = _expected(reference, coefficients, warp, weights, 0.5, degree)
    # float32 sums of 169 terms; 2e-5 px of slack in the spline pieces of "still", "hardly"
    scale = np.array([1, 1, 1, 1, 6, 6, 36, 36, 36, 1, 6, 6, 36, 36, 36])
    assert_allclose(moments / scale, expected / scale, atol=1e-3)


def test_first_order_sums_are_the_same_without_the_second():
    reference, coefficients = _pictures(1)
    warp = np.array(WARPS["crossing"], dtype=float)
    both = np.zeros((2, 15))
    for moments, second in zip(both, (None, 1), strict=True):
        warped_moments(
            coefficients, None, X, Y, warp, RADIUS, second, reference, _weights(), LANE_X,
            np.float32(0.5), moments,
        )  # fmt: skip
    first = [0, 1, 2, 3, 4, 5, 9, 10, 11]
    assert_allclose(both[0, first], both[1, first], rtol=1e-4, atol=1e-4)
    assert (both[0, [6, 7, 8, 12, 13, 14]] == 0).all()


@pytest.mark.parametrize("terms", [1, 3, 6])
def test_hessian_is_that_of_the_residual_without_gain_and_offset(terms):
    reference, _ = _pictures(2)
    weights = _weights(holes=True)
    products, total, along = np.zeros((3, 15)), np.zeros(15), np.zeros(15)
    window = (slice(Y - RADIUS, Y + RADIUS + 1), slice(X - RADIUS, X + RADIUS + 1))
    inside = weights[:, :13].ravel() > 0
    grey, slope_x, slope_y = (plane.astype(float).ravel() for plane in reference[:, *window])
    second = 1 if terms == 6 else None
    reference_moments(
        reference, weights, LANE_X, Y - RADIUS, X - RADIUS, np.float32(0.4), second,
        products, total, along,
    )  # fmt: skip
    count, offset = inside.sum(), along[0] / inside.sum()
    energy = along[1] - along[0] * offset
    along[3:] -= offset * total[3:]
    hessian = np.zeros((12, 12))
    fill_hessian(products, total, along, float(count), energy, terms, hessian)

    images = [slope * term.ravel() for slope in (slope_x, slope_y) for term in _terms()[:terms]]
    images = np.stack(images)[:, inside]
    nuisance = np.stack([np.ones(count), grey[inside]])
    basis = np.linalg.qr(nuisance.T)[0].T
    images = images - images @ basis.T @ basis
    expected = np.tril(images @ images.T)
    size = 2 * terms
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert_allclose(np.tril(hessian[:size, :size]) / scale, expected / scale, atol=2e-5)
