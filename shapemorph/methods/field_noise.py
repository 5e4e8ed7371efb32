"""Random part of the uncertainty of positions and strains."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.methods.grid_windows import Windows
from shapemorph.methods.tangent_fit import TangentFit


def position_noise(
    mm_per_px: Floats, sigma_px: Floats, barycentric: Floats, vertex_noise: Floats
) -> Floats:
    """Predict the standard deviation of one component of a displacement.

    Parameters
    ----------
    mm_per_px : (N, 3, 2)
        Derivative of the deformed position by the deformed picture's coordinates.
    sigma_px : (N, 2)
        Standard deviation of the matched position, px.
    barycentric : (2, N, 3)
        Weights of the corners that the reference and the deformed position are
        interpolated from.
    vertex_noise : (2,)
        Standard deviation of one coordinate of a vertex of either mesh, mm.

    Returns
    -------
    (N,)
        Root mean square over the three components, mm.
    """
    matched = np.einsum("nac,nc->n", mm_per_px**2, sigma_px**2) / 3
    interpolated = (barycentric**2).sum(axis=2) * vertex_noise[:, None] ** 2
    noise: Floats = np.sqrt(matched + interpolated.sum(axis=0))
    return noise


def overlap_correlation(offsets: Ints, *, spacing: int, subset_size: int) -> Floats:
    """Correlation between the errors of neighbouring points whose subsets overlap.

    A matched position is an average of the image noise over its subset, so two errors
    share the part of the noise that lies in both: the correlation is the share of area
    in common.

    Parameters
    ----------
    offsets : (K, 2)
        Grid offsets (column, row) of the points of a window.
    spacing, subset_size : int
        px.

    Returns
    -------
    (K, K)
    """
    apart = np.abs(offsets[:, None] - offsets[None]) * (spacing / subset_size)
    shared: Floats = np.clip(1 - apart, 0, None).prod(axis=2)
    return shared


def slope_noise(fit: TangentFit, windows: Windows, sigma_px: Floats, correlation: Floats) -> Floats:
    """Propagate matching errors through the slopes of a window fit.

    Parameters
    ----------
    fit : TangentFit
    windows : Windows
        Of N windows with K points.
    sigma_px : (P, 2)
        Standard deviation of the matched positions of all grid points, px.
    correlation : (K, K)
        Between the errors of the points of a window.

    Returns
    -------
    (N, 2, 2, 2)
        Covariance of the two slopes (last two axes) of an error field in x and in y
        (axis 1), px^2 / mm^2.
    """
    sigma = np.where(windows.inside[:, :, None], sigma_px[windows.neighbours], 0.0)
    weighted = fit.slopes[:, None] * np.swapaxes(sigma, 1, 2)[:, :, None]
    covariance: Floats = weighted @ correlation @ np.swapaxes(weighted, 2, 3)
    return covariance


def strain_noise(slopes: Floats, carriers: Floats) -> Floats:
    """Turn the noise of slopes into that of Green-Lagrange strain.

    An error field e (px of the deformed picture) changes the strain by
    dE_ab = (e_,a . w_b + e_,b . w_a) / 2, where w_a = J^-1 C_a: J carries reference
    tangent coordinates to the deformed picture and C = F^T F.

    Parameters
    ----------
    slopes : (N, 2, 2, 2)
        From :func:`slope_noise`.
    carriers : (N, 2, 2)
        w_a for the two axes a (axis 1), mm/px.

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
