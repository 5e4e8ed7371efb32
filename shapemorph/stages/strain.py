"""Stage `strain`: Green-Lagrange strain on the surface's own tangent planes."""

from dataclasses import dataclass

import numpy as np

from shapemorph.config import StrainConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.status import PointStatus, count_statuses
from shapemorph.core.surface import StrainField, TrackedSurface
from shapemorph.methods.facet_strain import facet_strain
from shapemorph.methods.field_noise import overlap_correlation, slope_noise, strain_noise, turned
from shapemorph.methods.grid_windows import Windows, connected_windows
from shapemorph.methods.measures import WITHIN_NOISE
from shapemorph.methods.principal import principal
from shapemorph.methods.tangent_fit import TangentFit, fit_tangent

_CHUNK_POINTS = 400_000  # window points fitted at a time: bounds memory to some 200 MB


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
    sigma_tensor: Floats
    sigma_values: Floats
    mm_per_px: Floats


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
    chunk = max(1, _CHUNK_POINTS // config.window**2)
    for windows in connected_windows(usable, window=config.window, chunk=chunk):
        _measure(points, windows, tracked, grid)
    if not np.isfinite(points.values).any():
        raise StageError(
            f"expected at least one point with enough neighbours for a strain window of "
            f"{config.window} points, got none of {usable.size} ({count_statuses(tracked.status)}):"
            f" lower correlate.spacing, or look for why points were lost"
        )
    return _field(points, tracked, grid, config)


def _nothing(count: int) -> _Points:
    shapes = [(2, 3), (2, 3), (2, 2), (2, 2), (2,), (3,), (3,), (3,), (3,), ()]
    return _Points(*(np.full((count, *shape), np.nan) for shape in shapes))


def _measure(
    points: _Points, windows: Windows, tracked: TrackedSurface, grid: CorrelationGrid
) -> None:
    """Fill in the rows of the centres of some windows."""
    fit = fit_tangent(
        tracked.reference.reshape(-1, 3),
        tracked.deformed.reshape(-1, 3),
        grid.reference_px.reshape(-1, 2),
        windows,
    )
    rows = windows.centres
    metric = np.swapaxes(fit.gradient, 1, 2) @ fit.gradient
    tensor = (metric - np.eye(2)) / 2
    values, direction = principal(tensor)
    frame = _deformed_frame(fit.gradient)
    points.tangent[rows], points.deformed_tangent[rows] = fit.tangent, frame
    points.gradient[rows] = frame @ fit.gradient
    points.tensor[rows], points.values[rows] = tensor, values
    points.mm_per_px[rows] = fit.mm_per_px
    sources = _noise_sources(fit, windows, points.gradient[rows], tracked, grid)
    points.sigma_tensor[rows] = _combined(sources)[:, :3]
    noise = _combined([turned(*source, direction) for source in sources])
    points.sigma_values[rows] = noise[:, [0, 1, 3]]
    clear = values[:, 0] - values[:, 1] > WITHIN_NOISE * noise[:, 3]
    direction = np.where(clear[:, None], direction, np.nan)
    points.direction[rows] = _in_space(fit.tangent, direction)
    points.direction_deformed[rows] = _unit(fit.gradient @ direction[:, :, None])


def _noise_sources(
    fit: TangentFit,
    windows: Windows,
    gradient: Floats,
    tracked: TrackedSurface,
    grid: CorrelationGrid,
) -> list[tuple[Floats, Floats]]:
    """Noise of slopes and what it acts on: the pictures, the reference and the deformed mesh."""
    correlation = overlap_correlation(
        windows.offsets, spacing=grid.spacing, subset_size=grid.subset_size
    )
    metric = np.swapaxes(gradient, 1, 2) @ gradient
    by_px = metric @ np.swapaxes(_mm_per_px(fit, windows, grid), 1, 2)
    pictures = slope_noise(fit, windows, grid.sigma_px.reshape(-1, 2), correlation)
    sources = [(pictures, by_px)]
    if tracked.sigma_mesh is not None:
        for side, carriers in ((0, metric), (1, np.swapaxes(gradient, 1, 2))):
            sigma = np.repeat(tracked.sigma_mesh[..., side].reshape(-1, 1), 2, axis=1)
            sources.append((slope_noise(fit, windows, sigma, correlation), carriers))
    return sources


def _combined(sources: list[tuple[Floats, Floats]]) -> Floats:
    """Add independent sources: noise of E11, E22, E12 and E11 - E22, (N, 4)."""
    variances = [strain_noise(slopes, carriers) ** 2 for slopes, carriers in sources]
    combined: Floats = np.sqrt(np.sum(variances, axis=0))
    return combined


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
    points: _Points, tracked: TrackedSurface, grid: CorrelationGrid, config: StrainConfig
) -> StrainField:
    shape = tracked.status.shape
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
        sigma_tensor=points.sigma_tensor.reshape(*shape, 3),
        sigma_e1=points.sigma_values[:, 0].reshape(shape),
        sigma_e2=points.sigma_values[:, 1].reshape(shape),
        sigma_difference=points.sigma_values[:, 2].reshape(shape),
        facet_tensor=facet_strain(tracked.reference, tracked.deformed),
        window=config.window,
        gauge_px=gauge_px,
        gauge_mm=gauge_px * float(np.nanmedian(points.mm_per_px)),
    )
