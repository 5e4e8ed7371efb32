"""Bundle adjustment: all cameras and all places of the targets, by sparse least squares.

Each place of a target touches six unknowns that no other place touches; they are eliminated
from the normal equations (Schur complement), so that what is left to solve has a row for each
unknown of a camera, however many pictures there are. `scipy.optimize.least_squares` does not
know of that: with the same derivatives, for two cameras and twenty views, it takes twenty times
as long by its dense solver, and by LSMR it has not settled after fifty times as long.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.errors import StageError
from shapemorph.methods.cameras.bundle_model import (
    BLOCK,
    LENS,
    PLACE,
    Arrangement,
    Observations,
    moved,
    residuals_of,
    slopes_of,
)

_ROUNDS = 100
_SETTLED = 1e-10  # relative change of the sum of squares
_UNSETTLED = (
    "the pictures do not settle all unknowns of the cameras: show the target tilted in several "
    "ways and all over the picture, or lower calibrate.radial"
)
_DAMPING = 1e-4, 1e12  # at the start, and where it is given up


@dataclass(frozen=True, slots=True, eq=False)
class Adjusted:
    """What the adjustment settles on.

    Attributes
    ----------
    arrangement : Arrangement
    residuals : (M, 2) float64
        Seen minus predicted, px.
    covariance : (C * 16, C * 16) float64
        Of the unknowns of all cameras, 16 for each: fx, fy, cx, cy, k1, k2, k3, p1, p2, skew,
        three small turns about its own axes, translation; zero where held.
    """

    arrangement: Arrangement
    residuals: Floats
    covariance: Floats


def free_lens(*, radial: int, tangential: bool, skew: bool) -> Bools:
    """Say which of the ten unknowns of a lens are sought."""
    free = np.zeros(LENS, dtype=np.bool_)
    free[: 4 + radial] = True
    free[7:9] = tangential
    free[9] = skew
    return free


def adjust(
    seen: Observations, start: Arrangement, *, lens: Bools, fixed: int | None, cauchy: float | None
) -> Adjusted:
    """Find the cameras and places that best explain what was seen.

    Parameters
    ----------
    seen : Observations
    start : Arrangement
    lens : (10,) bool
        Which unknowns of each lens are sought, see :func:`free_lens`.
    fixed : int or None
        Camera whose place is held (it is the frame of the world); None if all places of cameras
        are held.
    cauchy : float or None
        Scale in px of residuals that count less; None: all count alike.

    Raises
    ------
    StageError
        If the pictures do not settle the unknowns.

    Notes
    -----
    Levenberg-Marquardt with analytic derivatives. The covariance takes the noise from the
    residuals and supposes that it is the same and independent in all of them.

    References
    ----------
    .. [1] Triggs, B. et al. Bundle adjustment: a modern synthesis (2000).
       :doi:`10.1007/3-540-44480-7_21`
    """
    free = _free(len(start.cameras), lens, fixed)
    at, residuals = start, residuals_of(seen, start)
    cost, damping = _cost(residuals, cauchy), _DAMPING[0]
    for _ in range(_ROUNDS):
        system = _normal_equations(seen, at, residuals, cauchy)
        before = cost
        while damping < _DAMPING[1]:
            trial = moved(at, *system.step(free, damping))
            tried = residuals_of(seen, trial)
            if _cost(tried, cauchy) <= cost:
                at, residuals, cost = trial, tried, _cost(tried, cauchy)
                damping = max(damping / 10, 1e-12)
                break
            damping *= 10
        if before - cost <= _SETTLED * before:
            break
    system = _normal_equations(seen, at, residuals, None)
    unknowns = int(free.sum()) + PLACE * len(at.poses)
    noise = float((residuals**2).sum()) / max(2 * len(residuals) - unknowns, 1)
    return Adjusted(at, residuals, noise * system.camera_covariance(free))


def _free(cameras: int, lens: Bools, fixed: int | None) -> Bools:
    free = np.zeros((cameras, BLOCK), dtype=np.bool_)
    free[:, :LENS] = lens
    if fixed is not None:
        free[np.arange(cameras) != fixed, LENS:] = True
    return free.ravel()


def _cost(residuals: Floats, cauchy: float | None) -> float:
    squares = (residuals**2).sum(axis=1)
    if not np.isfinite(squares).all():
        return float("inf")
    if cauchy is None:
        return float(squares.sum())
    return float(cauchy**2 * np.log1p(squares / cauchy**2).sum())


@dataclass(frozen=True, slots=True, eq=False)
class _System:
    """Normal equations in blocks: cameras (C*16), views (V, 6), and what couples them."""

    cameras: Floats
    views: Floats
    coupling: Floats
    camera_side: Floats
    view_side: Floats

    def _scales(self) -> tuple[Floats, Floats]:
        own: Floats = np.sqrt(np.maximum(np.diag(self.cameras), 1e-300))
        places: Floats = np.sqrt(np.maximum(np.einsum("vii->vi", self.views), 1e-300))
        return own, places

    def _reduced(self, damping: float) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Scale, damp, and eliminate the views."""
        own, places = self._scales()
        views = self.views / places[:, :, None] / places[:, None, :]
        views = views + damping * np.eye(PLACE)
        coupling = self.coupling / own[None, :, None] / places[:, None, :]
        inverse = np.asarray(np.linalg.inv(views), dtype=np.float64)
        across: Floats = coupling @ inverse
        cameras = self.cameras / own[:, None] / own[None, :]
        cameras = cameras + damping * np.eye(len(own))
        reduced = cameras - np.einsum("vip,vjp->ij", across, coupling)
        return reduced, across, inverse, own, places

    def step(self, free: Bools, damping: float) -> tuple[Floats, Floats]:
        """Solve for the next step of cameras (C * 16,) and views (V, 6)."""
        reduced, across, inverse, own, places = self._reduced(damping)
        right = self.camera_side / own - np.einsum("vip,vp->i", across, self.view_side / places)
        step = np.zeros(len(own))
        if free.any():
            step[free] = np.linalg.lstsq(reduced[np.ix_(free, free)], right[free])[0]
        coupling = self.coupling / own[None, :, None] / places[:, None, :]
        left = self.view_side / places - np.einsum("vip,i->vp", coupling, step)
        return step / own, np.einsum("vpq,vq->vp", inverse, left) / places

    def camera_covariance(self, free: Bools) -> Floats:
        """Inverse (C * 16, C * 16) of the reduced matrix, for noise of 1 px."""
        try:
            reduced, _, _, own, _ = self._reduced(0.0)
        except np.linalg.LinAlgError as error:
            raise StageError(_UNSETTLED) from error
        covariance = np.zeros_like(reduced)
        if not free.any():
            return covariance
        among = np.ix_(free, free)
        values, vectors = np.linalg.eigh(reduced[among])
        if values[0] <= len(own) * np.finfo(float).eps * values[-1]:
            raise StageError(_UNSETTLED)
        covariance[among] = (vectors / values) @ vectors.T
        scaled: Floats = covariance / own[:, None] / own[None, :]
        return scaled


def _normal_equations(
    seen: Observations, at: Arrangement, residuals: Floats, cauchy: float | None
) -> _System:
    own, places = slopes_of(seen, at)
    weights = np.ones(len(residuals))
    if cauchy is not None:
        weights = 1 / (1 + (residuals**2).sum(axis=1) / cauchy**2)
    count, views = len(at.cameras), len(at.poses)
    cameras = np.zeros((count * BLOCK, count * BLOCK))
    camera_side = np.zeros(count * BLOCK)
    place_blocks = np.zeros((views, PLACE, PLACE))
    place_side = np.zeros((views, PLACE))
    coupling = np.zeros((views, count * BLOCK, PLACE))
    for camera, view, rows in _groups(seen):
        a, b = own[rows].reshape(-1, BLOCK), places[rows].reshape(-1, PLACE)
        weight = np.repeat(weights[rows], 2)
        wa, wb, r = a * weight[:, None], b * weight[:, None], residuals[rows].ravel()
        block = slice(camera * BLOCK, (camera + 1) * BLOCK)
        cameras[block, block] += a.T @ wa
        camera_side[block] += wa.T @ r
        place_blocks[view] += b.T @ wb
        place_side[view] += wb.T @ r
        coupling[view, block] += wa.T @ b
    return _System(cameras, place_blocks, coupling, camera_side, place_side)


def _groups(seen: Observations) -> list[tuple[int, int, slice]]:
    """List the runs of observations of one camera and one view."""
    change = (np.diff(seen.camera) != 0) | (np.diff(seen.view) != 0)
    starts = np.concatenate([[0], np.flatnonzero(change) + 1, [len(seen.camera)]])
    return [
        (int(seen.camera[low]), int(seen.view[low]), slice(low, high))
        for low, high in pairwise(starts)
    ]
