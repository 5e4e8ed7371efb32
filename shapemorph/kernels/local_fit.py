"""Many small robust polynomial fits at once."""

import numpy as np
from numba import njit, prange

from shapemorph.core.arrays import Floats, Ints


@njit(cache=True, nogil=True, parallel=True)
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
    prediction = np.empty((queries.shape[0], 2))  # filled row by row: compiles faster
    gradient = np.empty((queries.shape[0], 2, 2))
    spread = np.empty(queries.shape[0])
    for q in prange(queries.shape[0]):
        spread[q] = _fit_one(
            source, target, neighbours[q], queries[q], sides[q], count, terms, floor,
            prediction[q], gradient[q],
        )  # fmt: skip
    return prediction, gradient, spread


@njit(cache=True)
def _fit_one(
    source: Floats,
    target: Floats,
    neighbours: Ints,
    query: Floats,
    side: Floats,
    count: int,
    terms: int,
    floor: float,
    prediction: Floats,
    gradient: Floats,
) -> float:
    """Fill in the prediction and gradient of one query; return the spread."""
    prediction[:] = np.nan
    gradient[:] = np.nan
    design, values = np.empty((count, terms)), np.empty((count, 2))
    used, reach = 0, 0.0
    for n in neighbours:
        dx, dy = source[n, 0] - query[0], source[n, 1] - query[1]
        if used < count and dx * side[0] + dy * side[1] >= 0.0:
            design[used, 1], design[used, 2] = dx, dy
            values[used, 0], values[used, 1] = target[n, 0], target[n, 1]
            reach += dx * dx + dy * dy
            used += 1
    if used < terms + 3 or reach == 0.0:
        return np.nan
    reach = np.sqrt(reach / used)
    for k in range(used):
        x, y = design[k, 1] / reach, design[k, 2] / reach
        design[k, 0], design[k, 1], design[k, 2] = 1.0, x, y
        if terms == 6:
            design[k, 3], design[k, 4], design[k, 5] = x * x, x * y, y * y
    solution = np.empty((terms, 2))
    spread = float(_robust_fit(design[:used], values[:used], floor, solution))
    for i in range(2):
        prediction[i] = solution[0, i]
        gradient[i, 0] = solution[1, i] / reach
        gradient[i, 1] = solution[2, i] / reach
    return spread


@njit(cache=True)
def _robust_fit(design: Floats, values: Floats, floor: float, solution: Floats) -> float:
    """Reweight until outliers have little say; return the median misfit."""
    used, terms = design.shape
    weights, misfit = np.ones(used), np.empty(used)
    normal = np.empty((terms, terms))
    median = 0.0
    for _ in range(4):
        _weighted_fit(design, values, weights, normal, solution)
        for k in range(used):
            dx, dy = values[k, 0], values[k, 1]
            for t in range(terms):
                dx -= design[k, t] * solution[t, 0]
                dy -= design[k, t] * solution[t, 1]
            misfit[k] = np.sqrt(dx * dx + dy * dy)
        median = _middle(misfit)
        limit = max(1.5 * median, floor)
        for k in range(used):
            weights[k] = 1.0 / (1.0 + (misfit[k] / limit) ** 2) ** 2
    return median


@njit(cache=True)
def _middle(values: Floats) -> float:
    """Upper median, by insertion into a sorted list: there are few."""
    ordered = np.empty(values.size)
    for k in range(values.size):
        place = k
        while place > 0 and ordered[place - 1] > values[k]:
            ordered[place] = ordered[place - 1]
            place -= 1
        ordered[place] = values[k]
    return float(ordered[values.size // 2])


@njit(cache=True)
def _weighted_fit(
    design: Floats, values: Floats, weights: Floats, normal: Floats, right: Floats
) -> None:
    """Least squares by a Cholesky factor, the curved terms slightly held back."""
    used, terms = design.shape
    for a in range(terms):
        right[a, 0], right[a, 1] = 0.0, 0.0
        for b in range(terms):
            normal[a, b] = 0.0
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
