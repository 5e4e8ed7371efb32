"""Noise of strain against drawn errors."""

import numpy as np

from shapemorph.methods.strain_noise import joined, noise_parts, strain_noise


def test_noise_of_every_strain_component_is_that_of_drawn_errors():
    rng = np.random.default_rng(24)
    slopes, carriers = rng.normal(size=(2, 7)), rng.normal(size=(2, 2))
    spread = np.array([0.3, 0.7])
    errors = rng.normal(size=(200_000, 7, 2)) * spread
    change = np.einsum("bk,nkc,ac->nab", slopes, errors, carriers)
    strains = (change + np.swapaxes(change, 1, 2)) / 2
    drawn = [strains[:, 0, 0], strains[:, 1, 1], strains[:, 0, 1]]
    drawn.append(drawn[0] - drawn[1])
    covariance = np.einsum("ak,bk,c->cab", slopes, slopes, spread**2)
    found = strain_noise(covariance[None], carriers[None])[0]
    np.testing.assert_allclose(found, np.std(drawn, axis=1), rtol=0.01)  # 0.2 % scatter


def test_errors_along_and_across_a_direction_count_by_their_own_factors():
    rng = np.random.default_rng(25)
    gradient = np.array([[1.8, 0.5], [-0.2, 0.9]])
    vectors = np.linalg.eigh(gradient.T @ gradient)[1]
    direction = vectors[:, 1]
    slopes = rng.normal(size=(2, 7))
    factors = np.array([1.7, 0.6])
    axes = gradient @ np.stack([direction, vectors[:, 0]], axis=1)
    axes /= np.linalg.norm(axes, axis=0)
    errors = 0.01 * rng.normal(size=(200_000, 7, 2)) * factors @ axes.T  # in the deformed plane
    change = np.einsum("bk,nkc,ca->nab", slopes, errors, gradient)
    strains = (change + np.swapaxes(change, 1, 2)) / 2
    basis = np.stack([direction, vectors[:, 0]], axis=1)
    turned = basis.T @ strains @ basis
    one, two = turned[:, 0, 0], turned[:, 1, 1]
    covariance = np.einsum("ak,bk,c->cab", slopes, slopes, np.full(2, 0.01**2))
    parts = noise_parts([(covariance[None], gradient.T[None])], direction[None], np.zeros((1, 2)))
    tensor, principal = (joined(part, factors[None])[0] for part in parts)
    expected = np.std([strains[:, 0, 0], strains[:, 1, 1], strains[:, 0, 1]], axis=1)
    np.testing.assert_allclose(tensor, expected, rtol=0.01)  # 0.2 % scatter
    np.testing.assert_allclose(principal, np.std([one, two, one - two], axis=1), rtol=0.01)
    alike = joined(parts[0], np.ones((1, 2)))[0]
    np.testing.assert_allclose(alike, strain_noise(covariance[None], gradient.T[None])[0, :3])
