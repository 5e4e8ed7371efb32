"""Random part of the uncertainty of positions and strains."""

import numpy as np
from scipy.ndimage import uniform_filter

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.methods.grid_windows import Windows
from shapemorph.methods.quadratic_fit import quadratics
from shapemorph.methods.tangent_fit import TangentFit

_FEWEST = 100  # windows that settle the scatter to a few percent
_QUIET, _QUIET_NORMAL = 0.25, -0.6745  # quantile of the misfits, and that of the unit normal
_CLEARLY, _MOST = 1.6, 30.0  # times the misfit of noise: one mean in a hundred reaches the first
_CUBIC_GAIN = 4.0
_DOMAIN = 8  # subsets across: correlations have died out


def position_covariance(
    scales: tuple[Floats, Floats], gradient: Floats, sigma_px: Floats, sigma_mesh: Floats
) -> Floats:
    """Predict the covariance of a deformed position along its surface.

    A match errs by the noise of the pictures and by what noisy vertices do to the pattern
    on either side.

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

    Returns
    -------
    (N, 3, 3)
        Against the true position of the material at the reference position, in the frame
        of the deformed file, mm^2.
    """
    reference, deformed = scales
    matched = deformed * sigma_px[:, None]
    stretched = deformed @ gradient @ _pseudo_inverse(reference) * sigma_mesh[:, :1, None]
    own = deformed @ _pseudo_inverse(deformed) * sigma_mesh[:, 1:, None]
    parts = np.concatenate([matched, stretched, own], axis=2)
    covariance: Floats = parts @ np.swapaxes(parts, 1, 2)
    return covariance


def scatter_about_fits(
    misfit: Floats, variance: Floats, correlation: Floats, offsets: Ints
) -> tuple[float, Floats]:
    """Compare what window fits leave of the matched positions with what is predicted.

    The quietest quarter of the windows tells the noise: kinks, wrong matches and what is
    finer than the fits follow are elsewhere. Where windows all around leave clearly more
    than that, the excess is taken for cubics. The slopes of a quadratic over five points
    feel them more than noise that leaves as much: the variance is 8 times as large for a
    cubic along the slope, 1.5 or 0 times for those across it; 4 is taken.

    Parameters
    ----------
    misfit : (R, C)
        Sums of squares that quadratics leave of the two components along the surface over
        full windows, mm^2; NaN where unknown.
    variance : (R, C)
        Predicted variance of both components together, mm^2.
    correlation : (K, K)
        Between the errors of the points of a window.
    offsets : (K, 2)
        Of these points, in grid points.

    Returns
    -------
    overall : float
        Standard deviation of the positions over the predicted one; 1 where fewer than 100
        windows can tell.
    of_slopes : (R, C)
        That of the slopes, `overall` or more.
    """
    terms = quadratics(offsets[None].astype(np.float64))[0]
    left = np.eye(len(terms)) - terms @ np.linalg.pinv(terms)
    expected = left @ correlation @ left
    mean = float(np.trace(expected))
    freedom = 2 * mean**2 / float((expected**2).sum())  # of the two components
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = misfit / (variance * mean)
    known = np.isfinite(ratio)
    if np.count_nonzero(known) < _FEWEST:
        return 1.0, np.ones_like(misfit)
    spread = 2 / (9 * freedom)
    quiet = (1 - spread + _QUIET_NORMAL * np.sqrt(spread)) ** 3  # Wilson and Hilferty, 1931
    square = float(np.quantile(ratio[known], _QUIET)) / quiet
    around = _local_mean(np.minimum(np.where(known, ratio, 0.0) / square, _MOST), known)
    excess = np.maximum(around - _CLEARLY, 0.0)
    return float(np.sqrt(square)), np.sqrt(square * (1 + _CUBIC_GAIN * excess))


def _local_mean(values: Floats, known: Bools) -> Floats:
    """Mean of what is known within two points, 0 without any."""
    total = uniform_filter(np.where(known, values, 0.0), 5, mode="constant")
    share = uniform_filter(known.astype(np.float64), 5, mode="constant")
    mean: Floats = total / np.maximum(share, 1e-6)
    return mean


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


def match_correlation(offsets: Ints, *, spacing: int, subset_size: int, smoothing: float) -> Floats:
    """Correlation between the errors of neighbouring matches.

    Where the pictures were warped by what a first search had found, smoothed, a match
    follows the noise further: the error is A (1 + S (1 - A)) n with the average A over the
    subset and the smoothing S. That is a higher peak with negative shoulders. (Measured on
    synthetic pairs, subsets of 19 px: 0.74, 0.42, 0.12, -0.05 at 5, 10, 15, 20 px; here
    0.75, 0.42, 0.12, -0.07; plain averages have 0.74, 0.47, 0.21, 0.)

    Parameters
    ----------
    offsets : (K, 2)
        Grid offsets (column, row) of the points of a window.
    spacing, subset_size : int
        px.
    smoothing : float
        Standard deviation of the Gaussian weights of the quadratic fits that smoothed what
        was found, in subsets; 0: no warp was renewed.

    Returns
    -------
    (K, K)
    """
    if smoothing == 0:
        return overlap_correlation(offsets, spacing=spacing, subset_size=subset_size)
    wave = 2 * np.pi * np.fft.fftfreq(_DOMAIN * subset_size)
    box = np.zeros(_DOMAIN * subset_size)
    box[: subset_size // 2 + 1] = box[-(subset_size // 2) :] = 1 / subset_size
    average = np.fft.fft(box).real
    average = average[:, None] * average
    square = (smoothing * subset_size) ** 2 * (wave[:, None] ** 2 + wave**2) / 2
    transfer = average * (1 + (1 + square) * np.exp(-square) * (1 - average))
    shared = np.fft.ifft2(transfer**2).real
    apart = np.abs(offsets[:, None] - offsets[None]) * spacing
    near = np.minimum(apart, _DOMAIN * subset_size // 2)
    correlation: Floats = shared[near[..., 0], near[..., 1]] / shared[0, 0]
    return correlation


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
