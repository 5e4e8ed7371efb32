"""Smooth warps through scattered pairs of points: robust penalised cubic B-splines."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.core.matching import Warp
from shapemorph.kernels import spline_fit
from shapemorph.methods.warping import warp_points

CANDIDATES = 10.0 ** np.arange(-5, 1.1)
SAMPLE = 250  # points that cross validation leaves out, one at a time
REWEIGHTINGS = 2
OUTLIER_SCALES = 4.0
KINK_ALLOWANCE = 0.05  # misfit, in spacings, that a kink of the map may cause


@dataclass(frozen=True, slots=True, eq=False)
class WarpFit:
    """A warp and how well it predicts.

    Attributes
    ----------
    warp : Warp
    smoothing : float
        The weight of the bending energy that was used.
    left_out : (K,) float64
        Distance of sampled points from the warp that is fitted without them, px.
    """

    warp: Warp
    smoothing: float
    left_out: Floats


@dataclass(frozen=True, slots=True, eq=False)
class _Problem:
    """Everything that stays the same while weights and smoothing change."""

    first: Ints
    basis: Floats
    values: Floats
    importance: Floats
    bending: Floats
    shape: tuple[int, int]
    spacing: float

    def factor(self, weights: Floats, smoothing: float) -> tuple[Floats, Floats]:
        """Factorise and solve for given weights; bending is per average weight of a cell."""
        band, right = spline_fit.data_equations(
            self.first, self.basis, weights, self.values, *self.shape
        )
        density = weights.sum() / (self.shape[0] * self.shape[1])
        factor = spline_fit.factorise(band + smoothing * density * self.bending)
        return factor, spline_fit.solve(factor, right)

    def residuals(self, coefficients: Floats) -> Floats:
        """(N,) distance of each point from the surface."""
        steps = np.arange(4)
        index = self.first[:, None, None] + steps[:, None] * self.shape[1] + steps
        local = coefficients[index.reshape(len(self.first), 16)]
        misfit: Floats = self.values - np.einsum("nk,nkd->nd", self.basis, local)
        return np.hypot(misfit[:, 0], misfit[:, 1])

    def robust_weights(self, residuals: Floats) -> Floats:
        """(N,) importance, lowered for points far from the surface."""
        spread = 1.4826 * float(np.median(residuals))
        limit = max(OUTLIER_SCALES * spread, KINK_ALLOWANCE * self.spacing)
        return self.importance / (1.0 + (residuals / limit) ** 2) ** 2


def fit_warp(
    source_px: Floats,
    target_px: Floats,
    *,
    extent: tuple[Floats, Floats],
    spacing: float,
    smoothing: float | None,
    weights: Floats | None = None,
) -> Warp:
    """Fit a smooth warp that carries `source_px` to `target_px`; see :func:`fit_warp_checked`."""
    fit = fit_warp_checked(
        source_px, target_px, extent=extent, spacing=spacing, smoothing=smoothing, weights=weights
    )
    return fit.warp


def fit_warp_checked(
    source_px: Floats,
    target_px: Floats,
    *,
    extent: tuple[Floats, Floats],
    spacing: float,
    smoothing: float | None,
    weights: Floats | None = None,
) -> WarpFit:
    """Fit a smooth warp through scattered pairs, and say how well it predicts.

    A uniform cubic B-spline that minimises the weighted squared misfit plus a bending
    energy of its coefficients. Where there are no points the bending energy alone rules:
    gaps are bridged like a thin plate and rims are continued linearly. Points that
    contradict their neighbours lose their weight (iteratively reweighted least squares).

    Parameters
    ----------
    source_px, target_px : (N, 2)
        Pairs of positions, px; rows with a NaN are left out. At least 3, not in one line.
    extent : two (2,) arrays
        Lowest and highest source position (x, y) at which the warp must be defined, px.
    spacing : float
        Distance between coefficients, px of the source.
    smoothing : float or None
        Weight of the squared second differences of the coefficients (c_xx^2 + 2 c_xy^2 +
        c_yy^2), relative to the mean number of points per coefficient. None: the
        candidate that predicts left-out points best.
    weights : (N,) or None
        Importance of each pair, > 0; 1 / variance for pairs of different accuracy.

    Raises
    ------
    DataError
        If the pairs cannot fix a warp.

    References
    ----------
    P. H. C. Eilers, B. D. Marx, "Flexible smoothing with B-splines and penalties",
    Statistical Science 11 (1996), doi:10.1214/ss/1038425655.
    """
    source, target, importance = _usable(source_px, target_px, weights)
    origin, shape = _layout(extent, spacing)
    affine = _affine_fit(source, target, importance)
    flip = shape[1] > shape[0]  # number along the short side: the band is narrower
    in_grid = np.clip((source - origin) / spacing, 1.0, np.array(shape[::-1]) - 2.0)
    problem = _pose(in_grid, target - _apply(affine, source), importance, shape, spacing, flip=flip)
    smoothing, weights_now = _choose_smoothing(problem, smoothing)
    factor, solution = problem.factor(weights_now, smoothing)
    left_out = _left_out(problem, factor, solution, weights_now)
    grid = solution.reshape(*problem.shape, 2)
    grid = grid.swapaxes(0, 1) if flip else grid
    rows, cols = np.mgrid[: shape[0], : shape[1]].astype(np.float64)
    knots = origin + spacing * np.stack([cols, rows], axis=-1)
    coefficients = np.ascontiguousarray(grid + _apply(affine, knots))
    return WarpFit(Warp(coefficients, origin, float(spacing)), smoothing, left_out)


def fold_share(warp: Warp, mask: Bools, known: Floats, *, reach: float) -> float:
    """Share of the covered area where a warp turns the picture over.

    Parameters
    ----------
    warp : Warp
    mask : (H, W) bool
        The specimen in the source picture.
    known : (N, 2)
        Source positions of the pairs, px.
    reach : float
        Area within this distance of a pair counts as covered, px.

    Returns
    -------
    float
        0 where the warp is sound; NaN where nothing is covered.
    """
    from scipy.spatial import cKDTree

    stride = max(1, int(warp.spacing / 3))
    rows, cols = np.nonzero(mask[::stride, ::stride])
    points = np.column_stack([cols, rows]).astype(np.float64) * stride
    distance, _index = cKDTree(known).query(points, distance_upper_bound=reach)
    _targets, gradient = warp_points(warp, points[np.isfinite(distance)])
    if len(gradient) == 0:
        return float("nan")
    return float((np.linalg.det(gradient) <= 0).mean())


def _usable(
    source: Floats, target: Floats, weights: Floats | None
) -> tuple[Floats, Floats, Floats]:
    importance = np.ones(len(source)) if weights is None else np.asarray(weights, np.float64)
    good = np.isfinite(source).all(axis=1) & np.isfinite(target).all(axis=1) & (importance > 0)
    source, target, importance = source[good], target[good], importance[good]
    if len(source) < 3:
        raise DataError(f"a warp needs at least 3 pairs of finite points, got {len(source)}")
    thinnest = np.linalg.svd(source - source.mean(axis=0), compute_uv=False)
    if thinnest[1] < 1e-6 * thinnest[0]:
        raise DataError(f"a warp needs points that are not all in one line, got {len(source)} so")
    return source, target, importance / importance.mean()


def _layout(extent: tuple[Floats, Floats], spacing: float) -> tuple[Floats, tuple[int, int]]:
    """Origin and (rows, columns) of the coefficients that cover the extent."""
    low, high = np.asarray(extent[0], np.float64), np.asarray(extent[1], np.float64)
    cells = np.maximum(np.ceil((high - low) / spacing), 1).astype(int)
    slack = (cells * spacing - (high - low)) / 2
    return low - slack - spacing, (int(cells[1]) + 3, int(cells[0]) + 3)


def _pose(
    in_grid: Floats,
    values: Floats,
    importance: Floats,
    shape: tuple[int, int],
    spacing: float,
    *,
    flip: bool,
) -> _Problem:
    if flip:
        in_grid, shape = np.ascontiguousarray(in_grid[:, ::-1]), shape[::-1]
    first, basis = spline_fit.basis(in_grid, *shape)
    bending = spline_fit.bending_equations(*shape)
    return _Problem(first, basis, values, importance, bending, shape, spacing)


def _affine_fit(source: Floats, target: Floats, importance: Floats) -> Floats:
    """(3, 2) affine map by weighted least squares, one robust repeat."""
    design = np.column_stack([np.ones(len(source)), source])
    weights = importance
    for _ in range(2):
        root = np.sqrt(weights)[:, None]
        affine, *_rest = np.linalg.lstsq(design * root, target * root, rcond=None)
        misfit = np.linalg.norm(target - design @ affine, axis=1)
        limit = OUTLIER_SCALES * 1.4826 * max(float(np.median(misfit)), 1e-9)
        weights = importance / (1.0 + (misfit / limit) ** 2)
    return np.asarray(affine, np.float64)


def _apply(affine: Floats, points: Floats) -> Floats:
    moved: Floats = affine[0] + points[..., :1] * affine[1] + points[..., 1:] * affine[2]
    return moved


def _choose_smoothing(problem: _Problem, smoothing: float | None) -> tuple[float, Floats]:
    """Smoothing and robust weights; both together, for each needs the other."""
    weights = _reweighted(problem, 1e-2 if smoothing is None else smoothing)
    if smoothing is not None:
        return smoothing, weights
    best = _descend(lambda candidate: _prediction_cost(problem, weights, candidate))
    return best, _reweighted(problem, best, weights)


def _descend(cost: Callable[[float], float]) -> float:
    """Candidate of the lowest cost, found downhill from the middle one."""
    known: dict[int, float] = {}

    def cost_at(place: int) -> float:
        if place not in known:
            inside = 0 <= place < len(CANDIDATES)
            known[place] = cost(float(CANDIDATES[place])) if inside else np.inf
        return known[place]

    place = len(CANDIDATES) // 2
    while True:
        lowest = min((place, place - 1, place + 1), key=cost_at)
        if lowest == place:
            return float(CANDIDATES[place])
        place = lowest


def _reweighted(problem: _Problem, smoothing: float, weights: Floats | None = None) -> Floats:
    weights = problem.importance if weights is None else weights
    for _ in range(REWEIGHTINGS):
        _factor, solution = problem.factor(weights, smoothing)
        weights = problem.robust_weights(problem.residuals(solution))
    return weights


def _prediction_cost(problem: _Problem, weights: Floats, smoothing: float) -> float:
    """Mean squared distance of points from the warp fitted without them, outliers tamed."""
    factor, solution = problem.factor(weights, smoothing)
    distance = _left_out(problem, factor, solution, weights)
    trust = weights[_sample(len(weights))]
    return float((trust * distance**2).sum() / trust.sum())


def _left_out(problem: _Problem, factor: Floats, solution: Floats, weights: Floats) -> Floats:
    """(K,) exact leave-one-out distances of a spread sample of the points."""
    chosen = _sample(len(weights))
    pull = weights[chosen] * spline_fit.leverages(
        factor, problem.first[chosen], problem.basis[chosen], problem.shape[1]
    )
    left_out: Floats = problem.residuals(solution)[chosen] / np.maximum(1.0 - pull, 1e-6)
    return left_out


def _sample(count: int) -> Ints:
    """Spread sample of the points: the same for the same count."""
    if count <= SAMPLE:
        return np.arange(count)
    return np.sort(np.random.default_rng(0).permutation(count)[:SAMPLE])
