"""The radial law of the paper: r_m is a polynomial of the radial coordinate."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.methods.laws.radial import RadialPose, rotate

SAMPLE = 1500  # pairs are enough for a dozen unknowns
ROBUST = 0.02  # of the radius: misfits beyond it count less


@dataclass(frozen=True, slots=True, eq=False)
class PolynomialLaw:
    """r_m = c_1 rho + c_2 rho^2 + ... about two centres.

    Attributes
    ----------
    pose : RadialPose
    coefficients : (n,) float64
        c_1 ... c_n, mm^(1 - k).
    """

    pose: RadialPose
    coefficients: Floats

    def profile(self, radius: Floats) -> Floats:
        """(N,) r_m at radii (N,) of the deformed picture, mm."""
        powers = np.arange(1, len(self.coefficients) + 1)
        value: Floats = np.asarray(radius)[..., None] ** powers @ self.coefficients
        return value


def fit_polynomial_law(
    reference: Floats,
    deformed: Floats,
    *,
    order: int,
    centre: Floats | None,
    coefficients: Sequence[float] | None,
) -> PolynomialLaw:
    """Fit centres, turn and coefficients of a radial law to pairs of points.

    theta_m = theta + turn and r_m = sum of c_k rho^k, where (rho, theta) are polar
    coordinates in the deformed picture and (r_m, theta_m) in the reference picture. Where
    the deformed picture is an equidistant map of a sphere, rho is proportional to the
    polar angle phi of the paper; elsewhere it is another radial coordinate of the same
    point.

    Parameters
    ----------
    reference, deformed : (N, 2)
        Pairs of points in the two pictures, mm of each picture.
    order : int
        Highest power.
    centre : (2,) or None
        Of the reference picture, mm; None: fitted.
    coefficients : sequence of float or None
        c_1, c_2, ...; None: fitted.

    Raises
    ------
    StageError
        If there are too few pairs.

    References
    ----------
    .. [1] Genovese, K. and Sorgente, D. (2017). A morphing-based scheme for large
       deformation analysis with stereo-DIC. Optics and Lasers in Engineering, section on
       shape-morphing. :doi:`10.1016/j.optlaseng.2017.06.020`
    """
    from scipy.optimize import least_squares

    reference, deformed = _sample(reference, deformed, order)
    spread = float(np.sqrt(((deformed - deformed.mean(axis=0)) ** 2).sum(axis=1).mean()))
    size = float(np.sqrt(((reference - reference.mean(axis=0)) ** 2).sum(axis=1).mean()))
    law = _Unknowns(reference, deformed, order, centre, coefficients, spread)
    found = least_squares(
        law.misfit, law.start(), loss="soft_l1", f_scale=ROBUST * size, x_scale=law.scales()
    )
    return law.law(np.asarray(found.x))


@dataclass(frozen=True, slots=True, eq=False)
class _Unknowns:
    """Pairs and the meaning of the unknowns: deformed centre, turn, then what is not given."""

    reference: Floats
    deformed: Floats
    order: int
    centre: Floats | None
    coefficients: Sequence[float] | None
    spread: float

    def start(self) -> Floats:
        """Begin with the similarity that fits best, about the middle of the pairs."""
        middle, goal = self.deformed.mean(axis=0), self.reference.mean(axis=0)
        away, there = self.deformed - middle, self.reference - goal
        moment = away.T @ there
        along, across = moment[0, 0] + moment[1, 1], moment[0, 1] - moment[1, 0]
        turn, scale = np.arctan2(across, along), np.hypot(along, across) / (away**2).sum()
        if self.centre is not None:
            middle = middle + rotate((self.centre - goal)[None] / max(scale, 1e-9), -turn)[0]
        free = [] if self.centre is not None else [goal]
        slopes = np.zeros(0 if self.coefficients is not None else self.order)
        slopes[:1] = scale
        return np.concatenate([middle, [turn], *free, slopes])

    def scales(self) -> Floats:
        """Give the sizes of the unknowns."""
        start = self.start()
        scales = np.full(len(start), 0.1 * self.spread)
        scales[2] = 0.1
        if self.coefficients is None:
            scales[-self.order :] = 0.1
        return scales

    def law(self, unknowns: Floats) -> PolynomialLaw:
        """Read a law from the unknowns; fitted coefficients are those of rho / spread."""
        at = 3 if self.centre is not None else 5
        centre = self.centre if self.centre is not None else unknowns[3:5]
        if self.coefficients is not None:
            values = np.asarray(self.coefficients, np.float64)
        else:
            values = unknowns[at:] / self.spread ** np.arange(self.order)
        pose = RadialPose(np.asarray(centre, np.float64), unknowns[:2], float(unknowns[2]))
        return PolynomialLaw(pose, values)

    def misfit(self, unknowns: Floats) -> Floats:
        """(2 N,) how far the law puts the points from their partners, mm."""
        law = self.law(unknowns)
        misfit: Floats = (law.pose.carry(self.deformed, law.profile) - self.reference).ravel()
        return misfit


def _sample(reference: Floats, deformed: Floats, order: int) -> tuple[Floats, Floats]:
    good = np.isfinite(reference).all(axis=1) & np.isfinite(deformed).all(axis=1)
    if good.sum() < order + 5:
        raise StageError(
            f"a radial law of order {order} needs at least {order + 5} matches to be laid over "
            f"the pictures, got {good.sum()}"
        )
    chosen = np.flatnonzero(good)
    chosen = chosen[np.linspace(0, len(chosen) - 1, min(SAMPLE, len(chosen))).astype(int)]
    return reference[chosen], deformed[chosen]
