"""Many small least-squares problems at once."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats


def fit_operators(terms: Floats, inside: Bools, *, worst_condition: float) -> Floats:
    """Find the matrices that turn data into coefficients.

    Parameters
    ----------
    terms : (N, K, M)
        Values of the M terms at the K points of N problems, of order one (the caller
        scales them); rows that are not `inside` may hold anything finite.
    inside : (N, K)
        Which points take part.
    worst_condition : float
        Largest condition number of the normal equations to accept.

    Returns
    -------
    (N, M, K)
        Coefficients = operator @ data; zero for points that do not take part, NaN for
        problems whose points do not settle their coefficients.
    """
    used = terms * inside[:, :, None]
    across = np.swapaxes(used, 1, 2)
    normal = across @ used
    sound = _is_settled(normal, worst_condition)
    normal[~sound] = np.eye(terms.shape[2])
    operators = np.asarray(np.linalg.solve(normal, across), dtype=np.float64)
    operators[~sound] = np.nan
    return operators


def _is_settled(normal: Floats, worst_condition: float) -> Bools:
    """Whether the condition number of each symmetric matrix is small enough."""
    values = np.linalg.eigvalsh(normal)
    settled: Bools = (values[:, 0] > 0) & (values[:, -1] <= worst_condition * values[:, 0])
    return settled
