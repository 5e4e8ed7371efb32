"""What noisy slopes make of strain, with the noise along and across a direction apart."""

import numpy as np

from shapemorph.core.arrays import Floats

Source = tuple[Floats, Floats]
"""Covariances of slopes (N, 2, 2, 2) and what they act on (N, 2, 2): `strain_noise`."""


def noise_parts(sources: list[Source], direction: Floats, curving: Floats) -> tuple[Floats, Floats]:
    """Split the variances of strain by the component of the error that causes them.

    Errors of positions along and across the stretched direction are mispredicted in
    different measure. With factors s1 and s2 on them, the variance of any strain is
    s1^2 parts[0] + s2^2 parts[1] + s1 s2 parts[2].

    Parameters
    ----------
    sources : list of Source
        Independent of each other.
    direction : (N, 2)
        Of the larger principal strain, in the tangent basis of the reference. The error
        that it speaks of lies along the image of this direction on the deformed surface.
    curving : (N, 2)
        Further noise of E11 and E22; it is taken to be alike in all directions, half of it
        in E12.

    Returns
    -------
    of_tensor : (N, 3, 3)
        Parts (axis 1) of the variances of E11, E22 and E12.
    of_values : (N, 3, 3)
        Those of E1, E2 and E1 - E2 along fixed axes.
    """
    along = direction[:, :, None] * direction[:, None, :]
    tensor = _parts(sources, along)
    values = _parts([turned(*source, direction) for source in sources], np.diag([1.0, 0.0])[None])
    first, second = (curving**2).T
    mean = (first + second) / 2
    tensor[:, 2] += np.stack([first, second, mean / 2, first + second], axis=1)
    values[:, 2] += np.stack([first, second, mean / 2, first + second], axis=1)
    return tensor[..., :3], values[..., [0, 1, 3]]


def _parts(sources: list[Source], along: Floats) -> Floats:
    """Sum the parts of the variances (N, 3, 4) that all sources cause."""
    across = np.eye(2) - along
    first, second, whole = (
        np.sum([strain_noise(slopes, side @ carriers) ** 2 for slopes, carriers in sources], axis=0)
        for side in (along, across, np.eye(2))
    )
    return np.stack([first, second, whole - first - second], axis=1)


def joined(parts: Floats, factors: Floats) -> Floats:
    """Add up parts (N, 3, M) of variances under factors (N, 2) into standard deviations."""
    one, other = factors[:, :1], factors[:, 1:]
    variance = one**2 * parts[:, 0] + other**2 * parts[:, 1] + one * other * parts[:, 2]
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))


def strain_noise(slopes: Floats, carriers: Floats) -> Floats:
    """Turn the noise of slopes into that of Green-Lagrange strain.

    An error field e changes the strain by dE_ab = (e_,a . w_b + e_,b . w_a) / 2. If e is
    given on the deformed surface, w_a = F_a; on the reference surface, w_a = C_a with
    C = F^T F; in px of the deformed picture, w_a = J^-1 C_a, where J carries reference
    tangent coordinates to that picture.

    Parameters
    ----------
    slopes : (N, 2, 2, 2)
        From :func:`slope_noise`.
    carriers : (N, 2, 2)
        w_a for the two axes a (axis 1).

    Returns
    -------
    (N, 4)
        Standard deviations of E11, E22, E12 and of E11 - E22.
    """
    own = np.einsum("nac,ncaa->na", carriers**2, slopes)
    crossed = np.einsum("nac,ncbb->nab", carriers**2, slopes)
    mixed = np.einsum("nc,nc->n", carriers[:, 0] * carriers[:, 1], slopes[:, :, 0, 1])
    shear = (crossed[:, 0, 1] + crossed[:, 1, 0] + 2 * mixed) / 4
    difference = own[:, 0] + own[:, 1] - 2 * mixed
    variances = np.stack([own[:, 0], own[:, 1], shear, difference], axis=1)
    noise: Floats = np.sqrt(np.maximum(variances, 0))
    return noise


def turned(noise: Floats, carriers: Floats, direction: Floats) -> tuple[Floats, Floats]:
    """Refer slopes and carriers to axes along and across a direction of the tangent plane.

    Parameters
    ----------
    noise : (N, 2, 2, 2)
        From :func:`slope_noise`.
    carriers : (N, 2, 2)
        As in :func:`strain_noise`.
    direction : (N, 2)
        Unit vectors.

    Returns
    -------
    The same two arrays in the turned axes.
    """
    cosine, sine = direction[:, 0], direction[:, 1]
    axes = np.stack([cosine, sine, -sine, cosine], axis=1).reshape(-1, 2, 2)
    across = axes[:, None]
    return across @ noise @ np.swapaxes(across, 2, 3), axes @ carriers
