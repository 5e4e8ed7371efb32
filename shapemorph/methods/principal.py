"""Principal values and directions of plane symmetric tensors, and the measures made of them."""

import numpy as np

from shapemorph.core.arrays import Floats


def principal(tensor: Floats) -> tuple[Floats, Floats]:
    """Find principal values and the direction of the larger one.

    Closed form through half the angle of Mohr's circle: no iteration, no branch, and
    exactly equal values for a tensor that is a multiple of the identity.

    Parameters
    ----------
    tensor : (..., 2, 2)
        Symmetric; the upper right component is read.

    Returns
    -------
    values : (..., 2)
        Larger value first.
    direction : (..., 2)
        Unit direction of the larger value, first component >= 0; (1, 0) where both
        values agree.
    """
    mean = (tensor[..., 0, 0] + tensor[..., 1, 1]) / 2
    half = (tensor[..., 0, 0] - tensor[..., 1, 1]) / 2
    shear = tensor[..., 0, 1]
    radius = np.hypot(half, shear)
    angle = np.arctan2(shear, half) / 2
    values = np.stack([mean + radius, mean - radius], axis=-1)
    return values, np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def stretch_of(green: Floats) -> Floats:
    """Turn principal Green-Lagrange strain E into stretch, sqrt(1 + 2 E).

    Parameters
    ----------
    green : (...)
        Principal Green-Lagrange strain, > -1/2.

    Returns
    -------
    (...)
        Deformed over reference length; NaN at or below -1/2, where no length is left.
    """
    squared = 1 + 2 * np.asarray(green)
    return np.sqrt(np.where(squared > 0, squared, np.nan))


def hencky_of(green: Floats) -> Floats:
    """Turn principal Green-Lagrange strain E into Hencky strain, ln sqrt(1 + 2 E).

    Parameters
    ----------
    green : (...)
        Principal Green-Lagrange strain, > -1/2.

    Returns
    -------
    (...)
        True (logarithmic) strain; accurate for tiny E; NaN at or below -1/2.
    """
    sound = np.where(np.asarray(green) > -0.5, green, np.nan)
    strain: Floats = np.log1p(2 * sound) / 2
    return strain


def engineering_of(green: Floats) -> Floats:
    """Turn principal Green-Lagrange strain E into engineering strain, sqrt(1 + 2 E) - 1.

    The same number is the principal Biot strain, that of U - I.

    Parameters
    ----------
    green : (...)
        Principal Green-Lagrange strain, > -1/2.

    Returns
    -------
    (...)
        Change of length over reference length; accurate for tiny E; NaN at or below -1/2.
    """
    stretch = stretch_of(green)
    strain: Floats = 2 * np.asarray(green) / (stretch + 1)
    return strain


def almansi_of(green: Floats) -> Floats:
    """Turn principal Green-Lagrange strain E into Euler-Almansi strain, (1 - stretch^-2) / 2.

    Parameters
    ----------
    green : (...)
        Principal Green-Lagrange strain, > -1/2.

    Returns
    -------
    (...)
        Accurate for tiny E; NaN at or below -1/2.
    """
    strain: Floats = np.asarray(green) / stretch_of(green) ** 2
    return strain
