import numpy as np
import pytest

from shapemorph.kernels.membrane import add_pressure, membrane_energy

FACES = np.array([[0, 1, 2], [0, 2, 3]])
FLAT = np.array([[0.0, 0.0], [1.0, 0.1], [0.9, 1.2], [-0.1, 0.8]])


def slopes_and_volumes():
    slopes, volumes = [], []
    for face in FACES:
        edges = np.column_stack([np.ones(3), FLAT[face]])
        slopes.append(np.linalg.inv(edges)[1:].T)
        volumes.append(0.3 * abs(np.linalg.det(edges)) / 2)
    return np.array(slopes), np.array(volumes)


def stretched(rng):
    return np.column_stack([1.4 * FLAT, np.zeros(4)]) + rng.normal(0, 0.05, (4, 3))


def value_of(x, law):
    slopes, volumes = slopes_and_volumes()
    forces, blocks = np.zeros((4, 3)), np.zeros((2, 9, 9))
    energy = membrane_energy(x, FACES, slopes, volumes, *law, forces, blocks, True)
    return energy, forces, blocks


def pressed(x):
    forces, blocks = np.zeros((4, 3)), np.zeros((2, 9, 9))
    return add_pressure(x, FACES, 0.7, forces, blocks, True), forces, blocks


def gathered(blocks):
    whole = np.zeros((12, 12))
    for face, block in zip(FACES, blocks, strict=True):
        unknown = (3 * face[:, None] + np.arange(3)).ravel()
        whole[np.ix_(unknown, unknown)] += block
    return whole


def differences(value, x):
    """Central differences of energy and forces."""
    step, slope, stiff = 1e-6, np.zeros(12), np.zeros((12, 12))
    for k in range(12):
        moved = [x.copy(), x.copy()]
        moved[0].ravel()[k] += step
        moved[1].ravel()[k] -= step
        up, down = value(moved[0]), value(moved[1])
        slope[k] = (up[0] - down[0]) / (2 * step)
        stiff[k] = (up[1] - down[1]).ravel() / (2 * step)
    return slope, stiff


@pytest.mark.parametrize("law", [(0.25, 0.0, 1.0), (2.0, 1e-7, 0.75)])
def test_forces_and_stiffness_are_derivatives_of_the_energy(law):
    x = stretched(np.random.default_rng(1))
    _, forces, blocks = value_of(x, law)
    slope, stiff = differences(lambda at: value_of(at, law), x)
    np.testing.assert_allclose(forces.ravel(), slope, atol=1e-8)
    np.testing.assert_allclose(gathered(blocks), stiff, atol=1e-6)


def test_pressure_too():
    x = stretched(np.random.default_rng(2))
    _, forces, blocks = pressed(x)
    slope, stiff = differences(pressed, x)
    np.testing.assert_allclose(forces.ravel(), slope, atol=1e-8)
    np.testing.assert_allclose(gathered(blocks), stiff, atol=1e-7)


def test_energy_of_a_homogeneous_stretch_is_that_of_the_book():
    first, second = 1.7, 1.2
    x = np.column_stack([FLAT * [first, second], np.zeros(4)])
    energy, _, _ = value_of(x, (0.25, 0.0, 1.0))
    density = 0.25 * (first**2 + second**2 + (first * second) ** -2 - 3)
    assert energy == pytest.approx(density * slopes_and_volumes()[1].sum(), rel=1e-12)


def test_a_slack_membrane_is_not_indefinite():
    x = np.column_stack([0.8 * FLAT, np.zeros(4)])
    _, _, blocks = value_of(x, (0.25, 0.0, 1.0))
    across = gathered(blocks)[2::3, 2::3]
    assert np.linalg.eigvalsh(across).min() > -1e-12
