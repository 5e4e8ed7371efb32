"""Circles and spheres through points, from far less than half of them to flat ones.

References
----------
V. Pratt, Direct least-squares fitting of algebraic surfaces, SIGGRAPH 21 (1987),
doi 10.1145/37402.37420.
"""

import numpy as np

from shapemorph.core.arrays import Floats

FLATTEST = 1000.0  # radius over size beyond which a surface counts as this much curved
ROUNDS = 8
REACH = 4.685  # Tukey's constant: weight ends at so many standard deviations


def fit_round(points: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Fit a circle (D = 2) or a sphere (D = 3); points that lie off it lose their weight.

    Points on a line or a plane give a radius of a thousand times their extent, so that
    what is built on it stays defined.

    Parameters
    ----------
    points : (N, D)
    weights : (N,)
        Positive, such as areas.

    Returns
    -------
    centre : (D,)
    weights : (N,)
        Between 0 and the given ones.
    """
    middle = np.average(points, axis=0, weights=weights)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    local = (points - middle) / size
    kept = weights
    centre = _fit_once(local, kept)
    for _ in range(ROUNDS):
        distance = np.linalg.norm(local - centre, axis=1)
        kept = weights * tukey(distance - weighted_median(distance, kept))
        centre = _fit_once(local, kept)
    return middle + size * centre, kept


def _fit_once(points: Floats, weights: Floats) -> Floats:
    """Minimise A |x|^2 + B x + D in the mean square under |B|^2 - 4 A D = 1."""
    from scipy.linalg import eig

    rows = np.column_stack([(points**2).sum(axis=1), points, np.ones(len(points))])
    moments = (rows * (weights / weights.sum())[:, None]).T @ rows
    norm = np.eye(rows.shape[1])
    norm[[0, 0, -1, -1], [0, -1, 0, -1]] = [0.0, -2.0, -2.0, 0.0]
    _, vectors = eig(moments, norm)
    vectors = vectors.real.T
    lengths = np.einsum("ki,ij,kj->k", vectors, norm, vectors)
    errors = np.einsum("ki,ij,kj->k", vectors, moments, vectors)
    proper = np.flatnonzero(lengths > 1e-12 * (vectors**2).sum(axis=1))
    best = vectors[proper[(errors[proper] / lengths[proper]).argmin()]]
    normal = best[1:-1]
    curvature = 2.0 * best[0] / np.sqrt(best @ norm @ best)
    if abs(curvature) * FLATTEST < 1.0:
        flat: Floats = -normal / np.linalg.norm(normal) * FLATTEST * np.copysign(1.0, curvature)
        return flat
    centre: Floats = -normal / (2.0 * best[0])
    return centre


def tukey(residuals: Floats) -> Floats:
    """Weight of residuals: 1 at zero, 0 beyond 4.7 standard deviations, by the median."""
    scale = max(1.4826 * float(np.median(np.abs(residuals))), 1e-7)
    weight: Floats = np.clip(1.0 - (residuals / (REACH * scale)) ** 2, 0.0, None) ** 2
    return weight


def weighted_median(values: Floats, weights: Floats) -> float:
    """Value below which half of the weight lies."""
    order = np.argsort(values, kind="stable")
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, 0.5 * total[-1])])
