"""The star pattern: displacement of one amplitude whose period grows along x."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats

ORDER = 12  # of the polynomial through the measured amplitudes
KEPT = 0.9  # of the amplitude: what is lost at the spatial resolution is a tenth
STEPS = 4001  # places along the row where the polynomial is looked at


@dataclass(frozen=True, slots=True)
class Star:
    """What is imposed.

    Attributes
    ----------
    amplitude : float
        px.
    shortest, longest : float
        Period in the first and in the last column of the picture, px; linear between.
    width : int
        Columns of the picture.
    row : float
        Where the displacement has its full amplitude at every period, px.
    """

    amplitude: float
    shortest: float
    longest: float
    width: int
    row: float

    def period(self, x: Floats) -> Floats:
        """Period at columns x, px."""
        share = x / (self.width - 1)
        return self.shortest + (self.longest - self.shortest) * share

    def displacement(self, x: Floats, y: Floats) -> Floats:
        """Imposed displacement at positions of the reference picture, px."""
        phase = 2.0 * np.pi * (y - self.row) / self.period(x)
        return np.asarray(self.amplitude * np.cos(phase))


def spatial_resolution(star: Star, x: Floats, y: float, measured: Floats) -> float:
    """Find the period of which a tenth of the amplitude is lost.

    Parameters
    ----------
    star : Star
    x : (N,)
        Columns along a row at or beside that of full amplitude.
    y : float
        The row.
    measured : (N,)
        Displacement there, px; NaN where there is none.

    Returns
    -------
    float
        Period at which a polynomial of 12th order through measured / imposed first rises
        through 90 %, px; NaN if it never does, or too few points are known.

    References
    ----------
    P. L. Reu et al., "DIC Challenge 2.0", Exp. Mech. 62 (2022),
    doi:10.1007/s11340-021-00806-6.
    """
    known = np.isfinite(measured)
    if known.sum() < 2 * ORDER:
        return float("nan")
    ratio = measured[known] / star.displacement(x[known], np.full(int(known.sum()), y))
    fitted = np.polynomial.Polynomial.fit(x[known], ratio, ORDER)
    place = np.linspace(x[known].min(), x[known].max(), STEPS)
    kept = fitted(place) >= KEPT
    rises = np.flatnonzero(kept[1:] & ~kept[:-1])
    if len(rises) == 0:
        return float(star.period(place)[0]) if kept.all() else float("nan")
    return float(star.period(place)[rises[0] + 1])
