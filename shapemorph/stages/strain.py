"""Stage `strain`: Green-Lagrange strain on the surface's own tangent planes."""

from dataclasses import dataclass

import numpy as np

from shapemorph.config import StrainConfig
from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.status import PointStatus, count_statuses
from shapemorph.core.surface import StrainField, TrackedSurface
from shapemorph.methods.facet_strain import facet_strain
from shapemorph.methods.field_noise import (
    match_correlation,
    scatter_about_fits,
    slope_noise,
    uncorrelated,
)
from shapemorph.methods.grid_windows import Windows, connected_windows
from shapemorph.methods.measures import WITHIN_NOISE
from shapemorph.methods.mid_surface import Curvatures, curvatures, mid_metric
from shapemorph.methods.principal import principal
from shapemorph.methods.rim_cubics import PointNoise
from shapemorph.methods.strain_noise import joined, noise_parts
from shapemorph.methods.tangent_fit import TangentFit, fit_tangent
from shapemorph.methods.threads import run_at_once

_CHUNK_POINTS = 200_000  # window points fitted at a time by a thread: bounds memory to some 100 MB


@dataclass(frozen=True, slots=True, eq=False)
class _Points:
    """What the fits have found so far, one row a grid point."""

    tangent: Floats
    deformed_tangent: Floats
    gradient: Floats
    tensor: Floats
    values: Floats
    direction: Floats
    direction_deformed: Floats
    parts_of_tensor: Floats
    parts_of_values: Floats
    mm_per_px: Floats
    misfit: Floats
    cubic: Floats
    predicted: Floats


def strain(tracked: TrackedSurface, grid: CorrelationGrid, config: StrainConfig) -> StrainField:
    """Measure the strain of a tracked surface, point by point and facet by facet.

    Parameters
    ----------
    tracked : TrackedSurface
        Positions in mm; each state in its own frame, no alignment needed.
    grid : CorrelationGrid
        Supplies the noise of the matches, px.
    config : StrainConfig

    Returns
    -------
    StrainField
        NaN where a point is lost or has too few neighbours joined to it.

    Raises
    ------
    StageError
        If no point has a strain.
    """
    usable = tracked.status == PointStatus.OK
    points = _nothing(usable.size)
    skin = _skin(tracked, grid, config)
    chunk = max(1, _CHUNK_POINTS // config.window**2)
    parts = list(connected_windows(usable, window=config.window, chunk=chunk))
    run_at_once(lambda part: _measure(points, part, tracked, grid, skin, config.window), parts)
    if not np.isfinite(points.values).any():
        raise StageError(
            f"expected at least one point with enough neighbours for a strain window of "
            f"{config.window} points, got none of {usable.size} ({count_statuses(tracked.status)}):"
            f" lower correlate.spacing, or look for why points were lost"
        )
    scatter = _scatter(points, tracked, grid, config)
    return _field(points, tracked, grid, config, scatter)


def _nothing(count: int) -> _Points:
    shapes = [(2, 3), (2, 3), (2, 2), (2, 2), (2,), (3,), (3,), (3, 3), (3, 3), ()]
    shapes += [(2,), (2,), (2,)]
    return _Points(*(np.full((count, *shape), np.nan) for shape in shapes))


@dataclass(frozen=True, slots=True, eq=False)
class _Skin:
    """What carries the strain of a skin to the middle of the sheet, one row a grid point."""

    curved: Curvatures
    sides: Floats
    heights: Floats
    thickness: float


def _skin(tracked: TrackedSurface, grid: CorrelationGrid, config: StrainConfig) -> _Skin | None:
    """Prepare to leave the measured skin; None where the middle was measured."""
    if config.surface == "middle" or config.thickness is None:
        return None
    window = 2 * config.window - 1
    curved = curvatures(
        (tracked.reference.reshape(-1, 3), tracked.deformed.reshape(-1, 3)),
        grid.reference_px.reshape(-1, 2),
        tracked.status == PointStatus.OK,
        window=window,
        chunk=max(1, _CHUNK_POINTS // window**2),
    )
    outward = np.stack(
        [each.reshape(-1, 3) for each in (tracked.reference_normal, tracked.deformed_normal)],
        axis=1,
    )
    towards = np.sign((curved.normals * outward).sum(axis=2))
    sides = -towards if config.surface == "outer" else towards
    heights = tracked.sigma_heights
    heights = np.zeros((len(sides), 2)) if heights is None else heights.reshape(-1, 2)
    return _Skin(curved, sides, heights, config.thickness)


def _leave_skin(metric: Floats, rows: Ints, skin: _Skin) -> tuple[Floats, Floats]:
    """Metric (N, 2, 2) of the middle, and the noise that the curvatures put into E11, E22."""
    middle, offsets = mid_metric(
        metric, skin.curved.bends[rows], skin.sides[rows], thickness=skin.thickness
    )
    bent = offsets * skin.heights[rows] * skin.curved.gain[rows, None]
    stretched = np.diagonal(metric, axis1=1, axis2=2)
    noise: Floats = np.hypot(bent[:, :1] * stretched, bent[:, 1:])
    return middle, noise


def _measure(
    points: _Points,
    windows: Windows,
    tracked: TrackedSurface,
    grid: CorrelationGrid,
    skin: _Skin | None,
    window: int,
) -> None:
    """Fill in the rows of the centres of some windows."""
    fit = fit_tangent(
        tracked.reference.reshape(-1, 3),
        tracked.deformed.reshape(-1, 3),
        grid.reference_px.reshape(-1, 2),
        windows,
        _point_noise(tracked, _correlation(windows.offsets, grid)),
    )
    rows = windows.centres
    metric, curving = np.swapaxes(fit.gradient, 1, 2) @ fit.gradient, np.zeros((len(rows), 2))
    if skin is not None:
        metric, curving = _leave_skin(metric, rows, skin)
    tensor = (metric - np.eye(2)) / 2
    values, direction = principal(tensor)
    frame = _deformed_frame(fit.gradient)
    points.tangent[rows], points.deformed_tangent[rows] = fit.tangent, frame
    points.gradient[rows] = frame @ fit.gradient
    points.tensor[rows], points.values[rows] = tensor, values
    points.mm_per_px[rows] = fit.mm_per_px
    full = windows.inside.all(axis=1) & (windows.inside.shape[1] == window**2)
    sources = _noise_sources(fit, windows, points.gradient[rows], tracked, grid)
    parts = noise_parts(sources, direction, curving)
    points.parts_of_tensor[rows], points.parts_of_values[rows] = parts
    points.direction[rows] = _in_space(fit.tangent, direction)
    axes = _deformed_axes(fit.gradient, direction)
    points.direction_deformed[rows] = axes[:, :, 0]
    points.misfit[rows] = np.where(full[:, None], _along(axes, fit.misfit), np.nan)
    points.cubic[rows] = np.where(full[:, None], ((fit.cubic @ axes) ** 2).sum(axis=1), np.nan)
    if tracked.covariance is not None:
        points.predicted[rows] = _along(axes, tracked.covariance.reshape(-1, 3, 3)[rows])


def _point_noise(tracked: TrackedSurface, correlation: Floats) -> PointNoise | None:
    """Noise of the deformed positions; None where it is not known."""
    if tracked.covariance is None:
        return None
    variance = np.trace(tracked.covariance.reshape(-1, 3, 3), axis1=1, axis2=2)
    return PointNoise(np.sqrt(np.maximum(variance, 0.0)), correlation)


def _noise_sources(
    fit: TangentFit,
    windows: Windows,
    gradient: Floats,
    tracked: TrackedSurface,
    grid: CorrelationGrid,
) -> list[tuple[Floats, Floats]]:
    """Noise of slopes and what it acts on: the pictures, the reference and the deformed mesh."""
    correlation = _correlation(windows.offsets, grid)
    metric = np.swapaxes(gradient, 1, 2) @ gradient
    by_px = metric @ np.swapaxes(_mm_per_px(fit, windows, grid), 1, 2)
    axes, sigma_px = uncorrelated(grid.covariance_px2.reshape(-1, 2, 2), windows)
    sources = [(slope_noise(fit, windows, sigma_px, correlation), by_px @ axes)]
    if tracked.sigma_mesh is not None:
        for side, carriers in ((0, metric), (1, np.swapaxes(gradient, 1, 2))):
            along = tracked.sigma_mesh[..., side].ravel()[windows.neighbours]
            sigma = np.repeat(along[..., None], 2, axis=2)
            sources.append((slope_noise(fit, windows, sigma, correlation), carriers))
    return sources


def _correlation(offsets: Ints, grid: CorrelationGrid) -> Floats:
    return match_correlation(
        offsets, spacing=grid.spacing, subset_size=grid.subset_size, smoothing=grid.smoothing
    )


def _deformed_axes(gradient: Floats, direction: Floats) -> Floats:
    """Find the unit vectors that the principal directions become, (N, 3, 2)."""
    across = np.stack([-direction[:, 1], direction[:, 0]], axis=1)
    images = [_unit(gradient @ side[:, :, None]) for side in (direction, across)]
    return np.stack(images, axis=2)


def _along(axes: Floats, moments: Floats) -> Floats:
    """Second moments (N, 3, 3) along two axes (N, 3, 2), (N, 2)."""
    found: Floats = (axes * (moments @ axes)).sum(axis=1)
    return found


def _scatter(
    points: _Points, tracked: TrackedSurface, grid: CorrelationGrid, config: StrainConfig
) -> tuple[float, Floats]:
    """Measure the scatter of the matches about the fits over the predicted one."""
    if tracked.covariance is None:
        return 1.0, np.ones((tracked.status.size, 2))
    span = np.arange(config.window) - config.window // 2
    offsets = np.stack([part.ravel() for part in np.meshgrid(span, span)], axis=1)
    shape = (*tracked.status.shape, 2)
    overall, of_slopes = scatter_about_fits(
        points.misfit.reshape(shape),
        points.cubic.reshape(shape),
        points.predicted.reshape(shape),
        _correlation(offsets, grid),
        offsets,
    )
    return overall, of_slopes.reshape(-1, 2)


def _mm_per_px(fit: TangentFit, windows: Windows, grid: CorrelationGrid) -> Floats:
    """Differentiate reference tangent coordinates (axis 2) by deformed px (axis 1)."""
    matched = grid.deformed_px.reshape(-1, 2)
    relative = matched[windows.neighbours] - matched[windows.centres][:, None]
    px_per_mm = fit.slopes @ np.where(windows.inside[:, :, None], relative, 0.0)
    turns = px_per_mm[:, 0, 0] * px_per_mm[:, 1, 1] - px_per_mm[:, 0, 1] * px_per_mm[:, 1, 0]
    sound = np.isfinite(turns) & (turns != 0)
    mm_per_px = np.full_like(px_per_mm, np.nan)
    mm_per_px[sound] = np.linalg.inv(px_per_mm[sound])
    return mm_per_px


def _deformed_frame(gradient: Floats) -> Floats:
    """Orthonormal basis of the deformed tangent plane, first axis along F t1, (N, 2, 3)."""
    first = _unit(gradient[:, :, :1])
    normal = np.cross(gradient[:, :, 0], gradient[:, :, 1])
    second = _unit(np.cross(normal, first)[:, :, None])
    return np.stack([first, second], axis=1)


def _unit(columns: Floats) -> Floats:
    """Normalise vectors (N, 3, 1) into (N, 3)."""
    vectors = columns[:, :, 0]
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0, length, np.nan)


def _in_space(tangent: Floats, direction: Floats) -> Floats:
    vectors: Floats = np.einsum("nj,nja->na", direction, tangent)
    return vectors


def _field(
    points: _Points,
    tracked: TrackedSurface,
    grid: CorrelationGrid,
    config: StrainConfig,
    scatter: tuple[float, Floats],
) -> StrainField:
    """Put everything together; directions that are noise are dropped."""
    shape = tracked.status.shape
    sigma_tensor = joined(points.parts_of_tensor, scatter[1])
    sigma_values = joined(points.parts_of_values, scatter[1])
    apart = points.values[:, 0] - points.values[:, 1]
    lost = ~(apart > WITHIN_NOISE * sigma_values[:, 2])
    points.direction[lost] = points.direction_deformed[lost] = np.nan
    gauge_px = float((config.window - 1) * grid.spacing + grid.subset_size)
    return StrainField(
        tangent=points.tangent.reshape(*shape, 2, 3),
        deformed_tangent=points.deformed_tangent.reshape(*shape, 2, 3),
        gradient=points.gradient.reshape(*shape, 2, 2),
        tensor=points.tensor.reshape(*shape, 2, 2),
        e1=points.values[:, 0].reshape(shape),
        e2=points.values[:, 1].reshape(shape),
        direction_1=points.direction.reshape(*shape, 3),
        direction_1_deformed=points.direction_deformed.reshape(*shape, 3),
        sigma_tensor=sigma_tensor.reshape(*shape, 3),
        sigma_e1=sigma_values[:, 0].reshape(shape),
        sigma_e2=sigma_values[:, 1].reshape(shape),
        sigma_difference=sigma_values[:, 2].reshape(shape),
        facet_tensor=facet_strain(tracked.reference, tracked.deformed),
        scatter=scatter[0],
        window=config.window,
        gauge_px=gauge_px,
        gauge_mm=gauge_px * float(np.nanmedian(points.mm_per_px)),
    )
