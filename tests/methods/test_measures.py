"""Measures against the tensors that define them, and their noise against draws."""

import numpy as np
import pytest
from scipy.linalg import sqrtm

from shapemorph.core.surface import StrainField
from shapemorph.methods.measures import measures_of, noise_of_measures, principal_measures
from shapemorph.methods.principal import principal

GRADIENT = np.array([[1.9, 0.7], [-0.2, 0.8]])
METRIC = GRADIENT.T @ GRADIENT
GREEN = (METRIC - np.eye(2)) / 2


def values_of(tensor):
    """Principal values, larger first."""
    return np.linalg.eigvalsh(tensor)[::-1]


@pytest.fixture(scope="module")
def measures():
    return principal_measures(*values_of(GREEN))


@pytest.mark.parametrize(
    ("name", "tensor"),
    [
        ("E", GREEN),
        ("stretch", sqrtm(METRIC)),
        ("biot", sqrtm(METRIC) - np.eye(2)),
        ("almansi", (np.eye(2) - np.linalg.inv(GRADIENT @ GRADIENT.T)) / 2),
    ],
)
def test_principal_values_are_those_of_the_tensor_that_defines_the_measure(measures, name, tensor):
    names = ("E1", "E2") if name == "E" else (f"{name}_1", f"{name}_2")
    np.testing.assert_allclose([measures[n] for n in names], values_of(tensor), rtol=1e-12)


def test_hencky_and_engineering_strain_follow_from_the_singular_values(measures):
    stretches = np.linalg.svd(GRADIENT, compute_uv=False)
    np.testing.assert_allclose(
        [measures["hencky_1"], measures["hencky_2"]], np.log(stretches), rtol=1e-12
    )
    np.testing.assert_allclose(
        [measures["engineering_1"], measures["engineering_2"]], stretches - 1, rtol=1e-12
    )


def test_area_and_thickness_follow_from_the_determinant(measures):
    assert measures["area_ratio"] == pytest.approx(np.linalg.det(GRADIENT), rel=1e-12)
    assert measures["thickness_strain"] == pytest.approx(-np.log(np.linalg.det(GRADIENT)))


def test_shear_is_the_largest_over_all_pairs_of_lines(measures):
    angle = np.linspace(0, np.pi, 100_001)
    first = np.stack([np.cos(angle), np.sin(angle)])
    second = np.stack([-np.sin(angle), np.cos(angle)])
    carried = GRADIENT @ first, GRADIENT @ second
    cosine = (carried[0] * carried[1]).sum(axis=0) / np.prod(
        [np.linalg.norm(line, axis=0) for line in carried], axis=0
    )
    assert measures["shear_angle"] == pytest.approx(np.arcsin(cosine.max()), abs=1e-8)
    tensor_shear = np.einsum("ik,ij,jk->k", first, GREEN, second)
    assert measures["shear_max"] == pytest.approx(tensor_shear.max(), abs=1e-8)


def test_nothing_deformed_is_zero_in_every_measure():
    found = principal_measures(np.zeros(1), np.zeros(1))
    ones = {"stretch_1", "stretch_2", "area_ratio"}
    assert {name for name, value in found.items() if value == 1} == ones
    assert all(value == 0 for name, value in found.items() if name not in ones)


def field_of(tensor, sigma_tensor):
    """Strain field of one row of tensors (N, 2, 2) in turned planes."""
    count = len(tensor)
    values, direction = principal(tensor)
    basis = np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0]])
    frames = np.broadcast_to(basis, (1, count, 2, 3))
    cosine, sine = direction.T
    sigmas = sigma_tensor[:2]
    along = np.stack([cosine**2, sine**2]) ** 2
    crossed = 4 * (cosine * sine * sigma_tensor[2]) ** 2
    sigma = np.sqrt(along.T @ sigmas**2 + crossed), np.sqrt(along[::-1].T @ sigmas**2 + crossed)
    double = np.cos(2 * np.arctan2(sine, cosine)), np.sin(2 * np.arctan2(sine, cosine))
    difference = np.hypot(double[0] * np.hypot(*sigmas), double[1] * 2 * sigma_tensor[2])
    return StrainField(
        tangent=frames,
        deformed_tangent=frames,
        gradient=tensor[None],
        tensor=tensor[None],
        e1=values[None, :, 0],
        e2=values[None, :, 1],
        direction_1=(direction @ basis)[None],
        direction_1_deformed=(direction @ basis)[None],
        sigma_tensor=np.broadcast_to(sigma_tensor, (1, count, 3)),
        sigma_e1=sigma[0][None],
        sigma_e2=sigma[1][None],
        sigma_difference=difference[None],
        facet_tensor=np.zeros((0, count - 1, 2, 2, 2)),
        scatter=1.0,
        window=5,
        gauge_px=1.0,
        gauge_mm=1.0,
    )


def test_noise_of_every_measure_is_that_of_drawn_tensors():
    rng = np.random.default_rng(6)
    sigma = np.array([0.002, 0.001, 0.0015])
    drawn = rng.normal(size=(100_000, 3)) * sigma
    error = np.stack([drawn[:, 0], drawn[:, 2], drawn[:, 2], drawn[:, 1]], axis=1)
    found = noise_of_measures(field_of(GREEN[None], sigma))
    measured = measures_of(field_of(GREEN + error.reshape(-1, 2, 2), sigma))
    names = [name for name in found if name != "sigma_E_tangent"]
    assert len(names) == 11
    for name in names:
        scatter = measured[name.removeprefix("sigma_")].std()
        np.testing.assert_allclose(found[name][0, 0], scatter, rtol=0.02, err_msg=name)
    np.testing.assert_allclose(measured["E_tangent"][0].std(axis=0), sigma, rtol=0.02)


def test_second_direction_stands_across_the_first_in_the_surface():
    found = measures_of(field_of(GREEN[None], np.full(3, 0.001)))
    first, second = found["direction_1"][0, 0], found["direction_2"][0, 0]
    assert np.linalg.norm(second) == pytest.approx(1)
    assert first @ second == pytest.approx(0, abs=1e-15)
    assert second @ np.cross(found["tangent_1"][0, 0], found["tangent_2"][0, 0]) == pytest.approx(
        0, abs=1e-15
    )
    inside = np.stack([found["tangent_1"][0, 0], found["tangent_2"][0, 0]]) @ second
    assert inside @ GREEN @ inside == pytest.approx(found["E2"][0, 0])


def test_anisotropy_is_missing_where_the_smaller_strain_is_noise():
    tensor = np.array([np.diag([0.4, 0.2]), np.diag([0.4, 0.002])])
    found = measures_of(field_of(tensor, np.full(3, 0.001)))["anisotropy"][0]
    np.testing.assert_allclose(found, [2, np.nan])
