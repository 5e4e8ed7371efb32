"""Height, pole and curvature of a dome, and the membrane stress that a pressure puts there."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.errors import StageError

_TERMS = 15  # of a polynomial of degree four in two coordinates
_FEWEST = 2 * _TERMS
_TRIMS, _TRIMMED = 10, 3.0  # rounds, and standard deviations beyond which a rim point is left out
_SHARE_OF_CAP = 0.25  # of the way from the pole to the rim


@dataclass(frozen=True, slots=True, eq=False)
class Dome:
    """A dome over its rim.

    Attributes
    ----------
    pole : int
        Row of the highest point.
    height : float
        Of the fitted pole over the plane of the rim, mm.
    cap : float
        Radius about the pole that the curvature was fitted over, mm.
    curvatures : (2,) float64
        Principal curvatures at the pole, larger first, positive for a dome, 1/mm.
    sigma_radius : float
        Standard deviation of `radius`, from what the fit leaves, mm.
    in_cap : (N,) bool
        Points of the cap.
    rim_scatter : float
        Root mean square distance of the rim from its plane, mm.
    """

    pole: int
    height: float
    cap: float
    curvatures: Floats
    sigma_radius: float
    in_cap: Bools
    rim_scatter: float

    @property
    def radius(self) -> float:
        """Radius of curvature at the pole, 2 / (sum of the principal curvatures), mm."""
        return float(2 / self.curvatures.sum())


def measure_dome(points: Floats, corners: Ints, *, cap: float | None) -> Dome:
    """Measure a dome.

    Parameters
    ----------
    points : (N, 3)
        Deformed positions, mm; NaN for points without a value.
    corners : (T, 3)
        Triangles between points with a value.
    cap : float or None
        Radius about the pole to fit over, mm; None: a quarter of the way to the rim.

    Returns
    -------
    Dome
        The plane of the rim is fitted to the borders of the surface by least squares, without
        what stands out; the pole is the point farthest from it; curvature and height come
        from a polynomial of degree four over the cap.

    Raises
    ------
    StageError
        If the surface is closed, or too few points lie in the cap.
    """
    rim = border_of(corners)
    if len(rim) < 3:
        raise StageError("expected a dome with a rim, got a closed surface: leave forming.dome out")
    origin, normal, scatter = _plane_of_rim(points[rim])
    used = np.unique(corners)
    heights = (points[used] - origin) @ normal
    sign = 1.0 if heights.max() >= -heights.min() else -1.0
    pole = int(used[np.argmax(sign * heights)])
    away = np.linalg.norm(points - points[pole], axis=1)
    reach = cap or _SHARE_OF_CAP * float(np.median(away[rim]))
    in_cap = np.isin(np.arange(len(points)), used) & (away <= reach)
    if np.count_nonzero(in_cap) < _FEWEST:
        raise StageError(
            f"expected at least {_FEWEST} points within {reach:.3g} mm of the pole, got "
            f"{np.count_nonzero(in_cap)}: raise forming.cap"
        )
    fit = _polynomial(points[in_cap] - points[pole], sign * normal)
    height = float(sign * (points[pole] - origin) @ normal) + fit.height
    return Dome(pole, height, reach, fit.curvatures, fit.sigma_radius, in_cap, scatter)


def border_of(corners: Ints) -> Ints:
    """Points on edges that belong to one triangle only, (B,)."""
    edges = np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    return np.unique(unique[count == 1])


def value_at_pole(dome: Dome, points: Floats, values: Floats) -> float:
    """Smooth values (N,) over the cap by a quadratic of the place and take it at the pole."""
    chosen = dome.in_cap & np.isfinite(values)
    place = points[chosen] - points[dome.pole]
    place = place @ np.linalg.svd(place, full_matrices=False)[2][:2].T / dome.cap
    x, y = place.T
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    return float(np.linalg.lstsq(terms, values[chosen])[0][0])


def membrane_stress(pressure: float, radius: float, thickness: float) -> float:
    """Stress of a thin spherical membrane under pressure, p R / 2 t, in units of the pressure."""
    return pressure * radius / (2 * thickness)


@dataclass(frozen=True, slots=True, eq=False)
class _Cap:
    height: float
    curvatures: Floats
    sigma_radius: float


def _plane_of_rim(points: Floats) -> tuple[Floats, Floats, float]:
    """Origin, normal and scatter of the plane of most rim points."""
    kept = np.ones(len(points), dtype=bool)
    for _ in range(_TRIMS):
        origin = points[kept].mean(axis=0)
        normal = np.linalg.svd(points[kept] - origin, full_matrices=False)[2][2]
        off = np.abs((points - origin) @ normal)
        scatter = float(np.sqrt(np.mean(off[kept] ** 2)))
        wanted = off <= max(_TRIMMED * scatter, np.finfo(float).tiny)
        if (wanted == kept).all() or np.count_nonzero(wanted) < 3:
            break
        kept = wanted
    return origin, normal, scatter


def _polynomial(relative: Floats, up: Floats) -> _Cap:
    """Fit the cap about its top by z(x, y) of degree four."""
    helper = np.cross(up, np.eye(3)[np.abs(up).argmin()])
    first = helper / np.linalg.norm(helper)
    x, y, z = np.stack([first, np.cross(up, first), up]) @ relative.T
    size = float(np.hypot(x, y).max())
    u, v = x / size, y / size
    powers = [(i, j) for total in range(5) for i in range(total, -1, -1) for j in [total - i]]
    terms = np.stack([u**i * v**j for i, j in powers], axis=1)
    solution, _, _, _ = np.linalg.lstsq(terms, z)
    left = z - terms @ solution
    noise = float(np.sqrt((left**2).sum() / max(len(z) - _TERMS, 1)))
    covariance = noise**2 * np.linalg.inv(terms.T @ terms)
    hessian = np.array([[2 * solution[3], solution[4]], [solution[4], 2 * solution[5]]]) / size**2
    slope = solution[1:3] / size
    curvatures = _principal_curvatures(slope, hessian)
    weights = np.zeros(_TERMS)
    weights[[3, 5]] = 1.0 / size**2  # the mean curvature is (z_xx + z_yy) / 2
    sigma_mean = float(np.sqrt(weights @ covariance @ weights))
    radius = 2 / curvatures.sum()
    return _Cap(float(solution[0]), curvatures, radius**2 * sigma_mean)


def _principal_curvatures(slope: Floats, hessian: Floats) -> Floats:
    """Curvatures of a graph z(x, y), larger first, positive where it falls off."""
    first = np.eye(2) + np.outer(slope, slope)
    second = -hessian / np.sqrt(1 + slope @ slope)
    values = np.linalg.eigvals(np.linalg.solve(first, second)).real
    curvatures: Floats = np.sort(values)[::-1]
    return curvatures
