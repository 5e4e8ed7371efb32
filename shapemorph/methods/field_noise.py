"""Random part of the uncertainty of positions and strains."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.methods.grid_windows import Windows
from shapemorph.methods.tangent_fit import TangentFit


def position_covariance(
    scales: tuple[Floats, Floats],
    gradient: Floats,
    sigma_px: Floats,
    sigma_mesh: Floats,
    height: Floats,
) -> Floats:
    """Predict the covariance of a deformed position.

    Along the surface a match errs by the noise of the pictures and by what noisy vertices
    do to the pattern on either side; across it, by the noise of the deformed mesh.

    Parameters
    ----------
    scales : two of (N, 3, 2)
        Derivative of the position by the picture's coordinates, reference and deformed,
        mm/px.
    gradient : (N, 2, 2)
        d deformed px / d reference px.
    sigma_px : (N, 2)
        Standard deviation of the matched position, px.
    sigma_mesh : (N, 2)
        That of one tangential component due to the reference and the deformed mesh, mm of
        their own surfaces.
    height : (N, 3)
        The normal of the deformed surface, times the standard deviation of its height, mm.

    Returns
    -------
    (N, 3, 3)
        Against the true position of the material at the reference position, in the frame
        of the deformed file, mm^2.
    """
    reference, deformed = scales
    matched = deformed * sigma_px[:, None]
    stretched = deformed @ gradient @ _pseudo_inverse(reference) * sigma_mesh[:, :1, None]
    along = deformed @ _pseudo_inverse(deformed) * sigma_mesh[:, 1:, None]
    parts = np.concatenate([matched, stretched, along, height[:, :, None]], axis=2)
    covariance: Floats = parts @ np.swapaxes(parts, 1, 2)
    return covariance


def interpolated_noise(barycentric: Floats, *, vertex_noise: float) -> Floats:
    """Noise of a position between three vertices (N,), from its weights (N, 3), mm."""
    noise: Floats = vertex_noise * np.sqrt((barycentric**2).sum(axis=1))
    return noise


def _pseudo_inverse(scale: Floats) -> Floats:
    """Carry steps in the surface to steps in the picture, (N, 2, 3); NaN where it is."""
    across = np.swapaxes(scale, 1, 2)
    gram = across @ scale
    lost = ~np.isfinite(gram).all(axis=(1, 2))
    gram[lost] = np.eye(2)
    return np.asarray(np.linalg.solve(gram, across), dtype=np.float64)


def overlap_correlation(offsets: Ints, *, spacing: int, subset_size: int) -> Floats:
    """Correlation between the errors of neighbouring points whose subsets overlap.

    A matched position is an average of the image noise over its subset, so two errors
    share the part of the noise that lies in both: the correlation is the share of area
    in common. (Measured on synthetic pairs, subsets of 21 px: 0.80, 0.53, 0.26 at 5, 10,
    15 px against 0.76, 0.52, 0.29.)

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


def slope_noise(fit: TangentFit, windows: Windows, sigma: Floats, correlation: Floats) -> Floats:
    """Propagate errors of positions through the slopes of a window fit.

    Parameters
    ----------
    fit : TangentFit
    windows : Windows
        Of N windows with K points.
    sigma : (P, 2)
        Standard deviations of the x and y components of an error at all grid points.
    correlation : (K, K)
        Between the errors of the points of a window.

    Returns
    -------
    (N, 2, 2, 2)
        Covariance of the two slopes (last two axes) of the error's x and y component
        (axis 1).
    """
    used = np.where(windows.inside[:, :, None], sigma[windows.neighbours], 0.0)
    weighted = fit.slopes[:, None] * np.swapaxes(used, 1, 2)[:, :, None]
    covariance: Floats = weighted @ correlation @ np.swapaxes(weighted, 2, 3)
    return covariance


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
