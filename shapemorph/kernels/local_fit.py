"""Many small robust polynomial fits at once."""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Floats, Ints


@njit(cache=True, parallel=True)
def fit_locally(
    source: Floats,
    target: Floats,
    neighbours: Ints,
    queries: Floats,
    sides: Floats,
    count: int,
    terms: int,
    floor: float,
) -> tuple[Floats, Floats, Floats]:
    """Predict the target at each query from its neighbours, outliers having little say.

    Parameters
    ----------
    source, target : (N, 2)
        Pairs of points.
    neighbours : (Q, K)
        Indices of the pairs that may speak for each query, nearest first.
    queries : (Q, 2)
        Where to predict, in the frame of `source`.
    sides : (Q, 2)
        Unit vector: only neighbours on that side of the query speak. Zero: all do.
    count : int
        At most so many neighbours speak.
    terms : int
        3: plane, 6: quadratic surface.
    floor : float
        Misfit that is never held against a neighbour.

    Returns
    -------
    prediction : (Q, 2)
    gradient : (Q, 2, 2)
        d target[i] / d source[j].
    spread : (Q,)
        Median misfit of the neighbours. All NaN with fewer than terms + 3 neighbours.
    """
    prediction = np.full((queries.shape[0], 2), np.nan)
    gradient = np.full((queries.shape[0], 2, 2), np.nan)
    spread = np.full(queries.shape[0], np.nan)
    for q in prange(queries.shape[0]):
        chosen = np.empty(count, np.int64)
        used, reach = 0, 0.0
        for n in neighbours[q]:
            dx, dy = source[n, 0] - queries[q, 0], source[n, 1] - queries[q, 1]
            if used < count and dx * sides[q, 0] + dy * sides[q, 1] >= 0.0:
                chosen[used] = n
                reach += dx * dx + dy * dy
                used += 1
        if used < terms + 3 or reach == 0.0:
            continue
        reach = np.sqrt(reach / used)
        design, values = np.ones((used, terms)), np.empty((used, 2))
        for k in range(used):
            x = (source[chosen[k], 0] - queries[q, 0]) / reach
            y = (source[chosen[k], 1] - queries[q, 1]) / reach
            design[k, 1], design[k, 2] = x, y
            if terms == 6:
                design[k, 3], design[k, 4], design[k, 5] = x * x, x * y, y * y
            values[k] = target[chosen[k]]
        solution, misfit = _robust_fit(design, values, floor)
        prediction[q] = solution[0]
        for i in range(2):
            gradient[q, i, 0] = solution[1, i] / reach
            gradient[q, i, 1] = solution[2, i] / reach
        spread[q] = misfit
    return prediction, gradient, spread


@njit(cache=True)
def _robust_fit(design: Floats, values: Floats, floor: float) -> tuple[Floats, float]:
    used, terms = design.shape
    weights = np.ones(used)
    solution, median = np.zeros((terms, 2)), 0.0
    for _ in range(5):
        solution = _weighted_fit(design, values, weights)
        misfit = np.empty(used)
        for k in range(used):
            dx, dy = values[k, 0], values[k, 1]
            for t in range(terms):
                dx -= design[k, t] * solution[t, 0]
                dy -= design[k, t] * solution[t, 1]
            misfit[k] = np.sqrt(dx * dx + dy * dy)
        median = np.median(misfit)
        limit = max(1.5 * median, floor)
        for k in range(used):
            weights[k] = 1.0 / (1.0 + (misfit[k] / limit) ** 2) ** 2
    return solution, median


@njit(cache=True)
def _weighted_fit(design: Floats, values: Floats, weights: Floats) -> Floats:
    """Least squares by a Cholesky factor, the curved terms slightly held back."""
    used, terms = design.shape
    normal, right = np.zeros((terms, terms)), np.zeros((terms, 2))
    for k in range(used):
        for a in range(terms):
            weighted = weights[k] * design[k, a]
            right[a, 0] += weighted * values[k, 0]
            right[a, 1] += weighted * values[k, 1]
            for b in range(a + 1):
                normal[a, b] += weighted * design[k, b]
    for a in range(terms):
        normal[a, a] += 1e-6 if a < 3 else 2e-2 * used
        for b in range(a + 1):
            for c in range(b):
                normal[a, b] -= normal[a, c] * normal[b, c]
            normal[a, b] = np.sqrt(normal[a, a]) if a == b else normal[a, b] / normal[b, b]
    for d in range(2):
        for a in range(terms):
            for c in range(a):
                right[a, d] -= normal[a, c] * right[c, d]
            right[a, d] /= normal[a, a]
        for a in range(terms - 1, -1, -1):
            for c in range(a + 1, terms):
                right[a, d] -= normal[c, a] * right[c, d]
            right[a, d] /= normal[a, a]
    return right
