import numpy as np
import pytest

from shapemorph.methods.principal import (
    almansi_of,
    engineering_of,
    hencky_of,
    principal,
    stretch_of,
)


def test_principal_values_and_direction_agree_with_an_eigenvalue_solver():
    rng = np.random.default_rng(1)
    tensor = rng.normal(size=(50, 2, 2))
    tensor = tensor + np.swapaxes(tensor, 1, 2)
    values, direction = principal(tensor)
    expected, vectors = np.linalg.eigh(tensor)
    np.testing.assert_allclose(values, expected[:, ::-1], atol=1e-13)
    aligned = np.abs(np.sum(direction * vectors[:, :, 1], axis=1))
    np.testing.assert_allclose(aligned, 1, atol=1e-12)
    assert (direction[:, 0] >= 0).all()


def test_equal_principal_values_are_equal_to_the_last_bit():
    values, _ = principal(0.3 * np.eye(2))
    assert values[0] == values[1] == 0.3


def test_missing_tensor_has_missing_principal_values():
    values, direction = principal(np.full((2, 2), np.nan))
    assert np.isnan(values).all()
    assert np.isnan(direction).all()


def test_doubled_length_is_known_by_every_measure():
    assert stretch_of(np.array(1.5)) == 2
    np.testing.assert_allclose(hencky_of(np.array(1.5)), np.log(2), rtol=1e-15)
    assert engineering_of(np.array(1.5)) == 1
    assert almansi_of(np.array(1.5)) == 0.375


@pytest.mark.parametrize("measure", [hencky_of, engineering_of, almansi_of])
def test_tiny_strain_keeps_its_digits_in_every_measure(measure):
    np.testing.assert_allclose(measure(np.array(1e-12)), 1e-12, rtol=1e-11)


@pytest.mark.parametrize("measure", [stretch_of, hencky_of, engineering_of, almansi_of])
def test_strain_of_vanished_length_is_missing_not_infinite(measure):
    assert np.isnan(measure(np.array([-0.5, -0.7]))).all()
