"""Rigid motions between paired points."""

import numpy as np
from scipy.spatial.transform import Rotation

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError
from shapemorph.core.transform import RigidTransform

_COLLINEAR = 1e-3  # second over first spread below which points form a line
_CLEARLY_BETTER = 3.0  # times smaller residual of the mirrored fit
_WORTH_A_DOUBT = 0.02  # of the spread: residuals below it need no explanation


def fit_rigid(source: Floats, target: Floats, weights: Floats) -> RigidTransform:
    """Find the rotation and translation that carry one set of points onto another.

    Parameters
    ----------
    source, target : (N, 3)
        Paired points, at least three and not on one line.
    weights : (N,)
        Non-negative.

    Returns
    -------
    RigidTransform
        ``target_from_source``, least squares, never a reflection.

    Raises
    ------
    DataError
        If the points do not settle a rotation.

    References
    ----------
    .. [1] Kabsch, W. (1976). Acta Cryst. A32, 922-923. :doi:`10.1107/S0567739476001873`
    """
    share = weights / weights.sum()
    centre, goal = share @ source, share @ target
    _refuse_lines(source - centre, share)
    _refuse_lines(target - goal, share)
    rotation, _ = Rotation.align_vectors(target - goal, source - centre, weights=weights)
    matrix = rotation.as_matrix()
    return RigidTransform(matrix, goal - matrix @ centre)


def residuals_of(transform: RigidTransform, source: Floats, target: Floats) -> Floats:
    """Distances (N,) between carried source points and their targets."""
    distances: Floats = np.linalg.norm(transform.apply(source) - target, axis=1)
    return distances


def refuse_mirrored(source: Floats, target: Floats) -> None:
    """Raise if one set is the mirror image of the other.

    Sets in one plane are their own mirror images and pass.

    Parameters
    ----------
    source, target : (N, 3)

    Raises
    ------
    DataError
        If a reflection fits far better than any rotation does.
    """
    weights = np.ones(len(source))
    mirror = np.array([-1.0, 1.0, 1.0])
    proper = _rms(residuals_of(fit_rigid(source, target, weights), source, target))
    mirrored = fit_rigid(source * mirror, target, weights)
    improper = _rms(residuals_of(mirrored, source * mirror, target))
    spread = _rms(np.linalg.norm(target - target.mean(axis=0), axis=1))
    if proper > _WORTH_A_DOUBT * spread and proper > _CLEARLY_BETTER * improper:
        raise DataError(
            f"expected landmarks of two shapes of one hand, got a mirrored set (rms {improper:.4g} "
            f"mm as a reflection, {proper:.4g} mm as a motion): check the signs and the order of "
            "the columns in the landmarks file"
        )


def fit_triples(source: Floats, target: Floats) -> tuple[Floats, Floats]:
    """Fit many rigid motions at once, each to a few pairs.

    Parameters
    ----------
    source, target : (H, K, 3)

    Returns
    -------
    rotations : (H, 3, 3)
    translations : (H, 3)
    """
    centre, goal = source.mean(axis=1), target.mean(axis=1)
    spread = np.swapaxes(target - goal[:, None], 1, 2) @ (source - centre[:, None])
    left, _, right = np.linalg.svd(spread)
    left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
    rotations: Floats = left @ right
    return rotations, goal - np.einsum("hij,hj->hi", rotations, centre)


def _refuse_lines(centred: Floats, share: Floats) -> None:
    spread = np.linalg.svd(centred * np.sqrt(share)[:, None], compute_uv=False)
    if len(centred) < 3 or spread[1] <= _COLLINEAR * spread[0]:
        raise DataError(
            f"expected at least 3 points that are not on one line, got {len(centred)} with "
            f"spreads {spread[0]:.4g} and {spread[1] if len(spread) > 1 else 0:.4g} mm: add a "
            "landmark off the line"
        )


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
