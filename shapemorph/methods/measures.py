"""Every measure of strain, made of one fitted surface gradient, and the noise of each."""

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.surface import StrainField
from shapemorph.methods.principal import almansi_of, engineering_of, hencky_of, stretch_of

WITHIN_NOISE = 3.0
"""Standard deviations below which a value says nothing."""


def principal_measures(e1: Floats, e2: Floats) -> dict[str, Floats]:
    """Turn principal Green-Lagrange strains into all other measures.

    Parameters
    ----------
    e1, e2 : (...)
        Principal Green-Lagrange strains, e1 >= e2 > -1/2.

    Returns
    -------
    dict of str to (...) float64
        By the names of the result files; NaN where no length is left.
    """
    first, second = stretch_of(e1), stretch_of(e2)
    hencky = hencky_of(e1), hencky_of(e2)
    engineering = engineering_of(e1), engineering_of(e2)
    squares = 2 + 2 * (e1 + e2)
    return {
        "E1": e1,
        "E2": e2,
        "hencky_1": hencky[0],
        "hencky_2": hencky[1],
        "stretch_1": first,
        "stretch_2": second,
        "engineering_1": engineering[0],
        "engineering_2": engineering[1],
        "biot_1": engineering[0],
        "biot_2": engineering[1],
        "almansi_1": almansi_of(e1),
        "almansi_2": almansi_of(e2),
        "shear_max": (e1 - e2) / 2,
        "shear_angle": np.arcsin(np.clip(2 * (e1 - e2) / squares, -1, 1)),
        "area_ratio": first * second,
        "thickness_strain": -(hencky[0] + hencky[1]),
    }


def measures_of(field: StrainField) -> dict[str, Floats]:
    """Gather all measures of a strain field, directions and bases too.

    Returns
    -------
    dict of str to (R, C, ...) float64
        By the names of the result files.
    """
    clear = np.abs(field.e2) > WITHIN_NOISE * field.sigma_e2
    tensor = field.tensor
    return {
        **principal_measures(field.e1, field.e2),
        "thinning": -np.expm1(-(hencky_of(field.e1) + hencky_of(field.e2))),
        "anisotropy": field.e1 / np.where(clear & (field.e2 != 0), field.e2, np.nan),
        "E_tangent": np.stack([tensor[..., 0, 0], tensor[..., 1, 1], tensor[..., 0, 1]], axis=-1),
        "tangent_1": field.tangent[..., 0, :],
        "tangent_2": field.tangent[..., 1, :],
        "direction_1": field.direction_1,
        "direction_2": _across(field.tangent, field.direction_1),
        "direction_1_deformed": field.direction_1_deformed,
        "direction_2_deformed": _across(field.deformed_tangent, field.direction_1_deformed),
    }


def noise_of_measures(field: StrainField) -> dict[str, Floats]:
    """Gather the standard deviations of the measures of a strain field, random part.

    Each follows from those of E1 and E2 and their covariance, to first order:
    d ln(stretch) = dE / stretch^2.

    Returns
    -------
    dict of str to (R, C, ...) float64
        By the names of the result files. Engineering and Biot strain have that of the stretch.
    """
    stretches = stretch_of(field.e1), stretch_of(field.e2)
    sigmas = field.sigma_e1, field.sigma_e2
    numbered = list(zip((1, 2), stretches, sigmas, strict=True))
    covariance = (sigmas[0] ** 2 + sigmas[1] ** 2 - field.sigma_difference**2) / 2
    logarithms = [sigma / stretch**2 for _, stretch, sigma in numbered]
    mixed = 2 * covariance / (stretches[0] * stretches[1]) ** 2
    thinning = np.sqrt(np.maximum(logarithms[0] ** 2 + logarithms[1] ** 2 + mixed, 0))
    return {
        "sigma_E1": field.sigma_e1,
        "sigma_E2": field.sigma_e2,
        "sigma_E_tangent": field.sigma_tensor,
        **{f"sigma_hencky_{k}": sigma / stretch**2 for k, stretch, sigma in numbered},
        **{f"sigma_stretch_{k}": sigma / stretch for k, stretch, sigma in numbered},
        **{f"sigma_almansi_{k}": sigma / stretch**4 for k, stretch, sigma in numbered},
        "sigma_shear_max": field.sigma_difference / 2,
        "sigma_area_ratio": stretches[0] * stretches[1] * thinning,
        "sigma_thickness_strain": thinning,
    }


def _across(basis: Floats, direction: Floats) -> Floats:
    """Turn a direction of a tangent plane by a quarter, from its first axis to its second."""
    along = np.einsum("...ja,...a->...j", basis, direction)
    turned: Floats = along[..., :1] * basis[..., 1, :] - along[..., 1:] * basis[..., 0, :]
    return turned
