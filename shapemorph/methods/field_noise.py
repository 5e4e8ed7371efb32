"""Random part of the uncertainty of positions and strains."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import map_coordinates, uniform_filter

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.methods.grid_windows import Windows
from shapemorph.methods.quadratic_fit import cubic_changes, quadratics
from shapemorph.methods.tangent_fit import TangentFit

_FEWEST = 100  # windows that settle the scatter to a few percent
_QUIET, _QUIET_NORMAL = 0.25, -0.6745  # quantile of the misfits, and that of the unit normal
_CLEARLY, _MOST = 1.8, 30.0  # times what noise does: one mean in a hundred reaches the first
_NEAR, _STEP = 10, 5  # points: half width of surroundings of one noise, and between them
_DOMAIN = 8  # subsets across: correlations have died out


def position_covariance(
    scales: tuple[Floats, Floats], gradient: Floats, covariance_px2: Floats, sigma_mesh: Floats
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
    covariance_px2 : (N, 2, 2)
        Of the matched position.
    sigma_mesh : (N, 2)
        Standard deviation of one tangential component due to the reference and the deformed
        mesh, mm of their own surfaces.

    Returns
    -------
    (N, 3, 3)
        Against the true position of the material at the reference position, in the frame
        of the deformed file, mm^2.
    """
    reference, deformed = scales
    stretched = deformed @ gradient @ _pseudo_inverse(reference) * sigma_mesh[:, :1, None]
    own = deformed @ _pseudo_inverse(deformed) * sigma_mesh[:, 1:, None]
    parts = np.concatenate([stretched, own], axis=2)
    matched = deformed @ covariance_px2 @ np.swapaxes(deformed, 1, 2)
    covariance: Floats = matched + parts @ np.swapaxes(parts, 1, 2)
    return covariance


def scatter_about_fits(
    misfit: Floats, cubic: Floats, variance: Floats, correlation: Floats, offsets: Ints
) -> tuple[float, Floats]:
    """Compare what window fits leave of the matched positions with what is predicted.

    The quietest quarter of the windows tells the noise, of the slopes that around each
    point: kinks, wrong matches and what is finer than the fits follow are elsewhere. Where a
    fit with cubic terms would have found other slopes, all around and by clearly more than
    noise makes it, that is taken for an error of the slopes.

    Parameters
    ----------
    misfit : (R, C, 2)
        Sums of squares that quadratics leave of two components along the surface over
        full windows, mm^2; NaN where unknown.
    cubic : (R, C, 2)
        Sums of squares of what cubic terms would change in the two slopes of either
        component, per step of the grid, mm^2; NaN likewise.
    variance : (R, C, 2)
        Predicted variance of these components, mm^2.
    correlation : (K, K)
        Between the errors of the points of a window.
    offsets : (K, 2)
        Of these points, in grid points.

    Returns
    -------
    overall : float
        Standard deviation of the positions over the predicted one, of both components
        together; 1 where fewer than 100 windows can tell.
    of_slopes : (R, C, 2)
        That of the slopes of either component.
    """
    terms = quadratics(offsets[None].astype(np.float64))[0]
    fit = np.linalg.pinv(terms)
    left = np.eye(len(terms)) - terms @ fit
    expected = left @ correlation @ left
    mean = float(np.trace(expected))
    freedom = mean**2 / float((expected**2).sum())  # of one component
    with np.errstate(divide="ignore", invalid="ignore"):
        both = misfit.sum(axis=2) / (variance.sum(axis=2) * mean)
        each = misfit / (variance * mean)
    known = np.asarray(np.isfinite(each).all(axis=2))
    if np.count_nonzero(known) < _FEWEST:
        return 1.0, np.ones_like(misfit)
    overall = _of_the_quiet(both[known], 2 * freedom)
    each[~known] = np.nan
    squares = np.stack([_of_the_quiet_around(each[..., k], freedom) for k in (0, 1)], axis=2)
    changes = _variance(cubic_changes(offsets), correlation)
    noise = _variance(fit[1:3], correlation)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (cubic / (variance * squares * changes)).mean(axis=2)
    around = _local_mean(np.minimum(np.where(known, ratio, 0.0), _MOST), known)
    excess = np.maximum(around - _CLEARLY, 0.0) * changes / noise
    return float(np.sqrt(overall)), np.sqrt(squares * (1 + excess[..., None]))


def _variance(slopes: Floats, correlation: Floats) -> float:
    """Variance of two slopes (2, K) together, of data of unit variance."""
    return float(np.trace(slopes @ correlation @ slopes.T))


def _of_the_quiet(ratios: Floats, freedom: float) -> float:
    """Mean of ratios that are noise, from their lower quartile (Wilson and Hilferty, 1931)."""
    return float(np.quantile(ratios, _QUIET) / _quiet_quartile(freedom))


def _quiet_quartile(freedom: float) -> float:
    """Lower quartile of noise whose mean is 1."""
    spread = 2 / (9 * freedom)
    return float((1 - spread + _QUIET_NORMAL * np.sqrt(spread)) ** 3)


def _of_the_quiet_around(ratios: Floats, freedom: float) -> Floats:
    """Mean of ratios (R, C) that are noise, around each point; of all where too few are near."""
    padded = np.pad(ratios, _NEAR, constant_values=np.nan)
    padded = np.pad(padded, ((0, _STEP), (0, _STEP)), constant_values=np.nan)
    around = sliding_window_view(padded, (2 * _NEAR + 1, 2 * _NEAR + 1))[::_STEP, ::_STEP]
    found = _lower_quartiles(around.reshape(*around.shape[:2], -1)) / _quiet_quartile(freedom)
    found[np.isnan(found)] = _of_the_quiet(ratios[np.isfinite(ratios)], freedom)
    at = np.mgrid[: ratios.shape[0], : ratios.shape[1]] / _STEP
    return np.asarray(map_coordinates(found, at, order=1))


def _lower_quartiles(values: Floats) -> Floats:
    """Lower quartile of each row (..., K) without its NaN; NaN where too few are left."""
    ordered = np.sort(values, axis=-1)  # NaN last
    count = np.isfinite(values).sum(axis=-1)
    place = _QUIET * np.maximum(count - 1, 0)
    below = place.astype(np.int64)[..., None]
    low, high = (np.take_along_axis(ordered, below + step, axis=-1)[..., 0] for step in (0, 1))
    quartile: Floats = low + (place - below[..., 0]) * (high - low)
    quartile[count < _FEWEST] = np.nan
    return quartile


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


def uncorrelated(covariance_px2: Floats, windows: Windows) -> tuple[Floats, Floats]:
    """Turn to axes in which the two components of an error have nothing in common.

    They are those of the centre of each window; what neighbours still have in common in
    them is left out. (A picture that was stretched twofold at 45 degrees has errors twice as
    large along the stretch as across; x and y alone do not tell.)

    Parameters
    ----------
    covariance_px2 : (P, 2, 2)
        Of the errors of all grid points, px^2.
    windows : Windows
        Of N windows with K points.

    Returns
    -------
    axes : (N, 2, 2)
        Orthonormal, in columns.
    sigma : (N, K, 2)
        Standard deviations along them at the points of the windows, px.
    """
    centre = np.where(np.isfinite(covariance_px2), covariance_px2, 0.0)[windows.centres]
    axes = np.linalg.eigh(centre)[1]
    x, y = axes[:, None, 0], axes[:, None, 1]
    xx, xy, yy = (covariance_px2[:, i, j][windows.neighbours] for i, j in ((0, 0), (0, 1), (1, 1)))
    variance = xx[..., None] * x**2 + 2 * xy[..., None] * x * y + yy[..., None] * y**2
    return axes, np.sqrt(np.maximum(variance, 0.0))


def slope_noise(fit: TangentFit, windows: Windows, sigma: Floats, correlation: Floats) -> Floats:
    """Propagate errors of positions through the slopes of a window fit.

    Parameters
    ----------
    fit : TangentFit
    windows : Windows
        Of N windows with K points.
    sigma : (N, K, 2)
        Standard deviations of two independent components of an error at the points of
        the windows.
    correlation : (K, K)
        Between the errors of the points of a window.

    Returns
    -------
    (N, 2, 2, 2)
        Covariance of the two slopes (last two axes) of the error's components (axis 1).
    """
    used = np.where(windows.inside[:, :, None], sigma, 0.0)
    weighted = fit.slopes[:, None] * np.swapaxes(used, 1, 2)[:, :, None]
    covariance: Floats = weighted @ correlation @ np.swapaxes(weighted, 2, 3)
    return covariance
