"""One row per measured point, with the arrays that users read."""

from typing import Any

import numpy as np

from shapemorph.core.arrays import Bools, Codes, Floats, Ints
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.measurement import Facets, Measurement
from shapemorph.core.status import PointStatus
from shapemorph.core.surface import Alignment, StrainField, TrackedSurface
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.charts.ownership import Ownership
from shapemorph.methods.measures import measures_of, noise_of_measures, principal_measures
from shapemorph.methods.principal import principal

_HEAD, _TAIL = slice(None, -1), slice(1, None)
_CORNERS = ((_HEAD, _HEAD), (_HEAD, _TAIL), (_TAIL, _TAIL), (_TAIL, _HEAD))  # around a cell
_FOR_LOST_POINTS_TOO = {"status", "chart", "reference_px", "zncc", "iterations"}


def assemble_measurement(
    grid: CorrelationGrid,
    tracked: TrackedSurface,
    alignment: Alignment,
    field: StrainField,
    ownership: Ownership,
) -> Measurement:
    """Gather everything that was measured at the grid points inside the mask.

    Parameters
    ----------
    grid : CorrelationGrid
    tracked : TrackedSurface
    alignment : Alignment
    field : StrainField
    ownership : Ownership
        Pages of the points; those that only repeat what another page shows are left out,
        but for the corners of cells along the seam.

    Returns
    -------
    Measurement
        Points that were followed but have no strain are DEGENERATE_FACET. Lost points
        keep their reference position, `reference_px`, `zncc` and `iterations`; everything
        else is NaN there.
    """
    status = _final_status(tracked, field)
    rows, whole = _taken(status, ownership.owned)
    arrays: dict[str, Any] = {
        "status": status,
        "chart": ownership.page,
        **_positions(grid, tracked, alignment, ownership),
        **measures_of(field),
        "zncc": grid.zncc,
        "iterations": grid.iterations,
        **_position_noise(tracked, alignment, field.scatter),
        **noise_of_measures(field),
    }
    lost = status != PointStatus.OK
    cells = _cells(whole, rows)
    outward = _is_outward(cells, tracked, rows)
    return Measurement(
        reference=tracked.reference[rows],
        cells=cells if outward else cells[:, ::-1].copy(),
        facets=_facets(cells, field.facet_tensor[whole], outward=outward),
        arrays={name: _rows_of(name, values, rows, lost) for name, values in arrays.items()},
        grid_index=np.flatnonzero(rows),
    )


def _taken(status: Codes, owned: Bools) -> tuple[Bools, Bools]:
    """Points (R, C) that are taken, and cells (R-1, C-1) between four of them that are OK."""
    sound = status == PointStatus.OK
    whole, touched = np.ones_like(sound[1:, 1:]), np.zeros_like(sound[1:, 1:])
    for corner in _CORNERS:
        whole &= sound[corner]
        touched |= owned[corner]
    whole &= touched
    rows = owned & (status != PointStatus.OUTSIDE_MASK)
    for corner in _CORNERS:
        rows[corner] |= whole
    return rows, whole


def _final_status(tracked: TrackedSurface, field: StrainField) -> Codes:
    measured = np.isfinite(field.e1) & np.isfinite(field.e2)
    status = tracked.status.copy()
    status[(status == PointStatus.OK) & ~measured] = PointStatus.DEGENERATE_FACET
    return status


def _positions(
    grid: CorrelationGrid,
    tracked: TrackedSurface,
    alignment: Alignment,
    ownership: Ownership,
) -> dict[str, Floats]:
    reference_from_deformed = RigidTransform(alignment.rotation, alignment.translation)
    return {
        "deformed_position": tracked.deformed,
        "displacement": reference_from_deformed.apply(tracked.deformed) - tracked.reference,
        "reference_px": _on_page(grid.reference_px, ownership.reference_left),
        "deformed_px": _on_page(grid.deformed_px, ownership.deformed_left),
    }


def _position_noise(
    tracked: TrackedSurface, alignment: Alignment, scatter: float
) -> dict[str, Floats]:
    """Give standard deviations of both positions and the displacement, by component, mm."""
    if tracked.covariance is None or tracked.sigma_heights is None:
        unknown = np.full_like(tracked.reference, np.nan)
        names = ("sigma_uvw", "sigma_points", "sigma_deformed_position")
        return {"sigma_displacement": tracked.sigma_position, **dict.fromkeys(names, unknown)}
    before = tracked.reference_normal * tracked.sigma_heights[..., :1]
    after = tracked.deformed_normal * tracked.sigma_heights[..., 1:]
    covariance = scatter**2 * tracked.covariance + after[..., :, None] * after[..., None, :]
    turned = alignment.rotation @ covariance @ alignment.rotation.T
    variances = _diagonal(turned) + before**2
    return {
        "sigma_displacement": np.sqrt(variances.mean(axis=-1)),
        "sigma_uvw": np.sqrt(variances),
        "sigma_points": np.abs(before),
        "sigma_deformed_position": np.sqrt(_diagonal(covariance)),
    }


def _diagonal(covariance: Floats) -> Floats:
    variances: Floats = np.diagonal(covariance, axis1=-2, axis2=-1)
    return variances


def _on_page(points_px: Floats, left: Floats) -> Floats:
    """Positions in the picture of the page itself."""
    return points_px - np.stack([left, np.zeros_like(left)], axis=-1)


def _rows_of(name: str, values: Any, rows: Bools, lost: Bools) -> Floats:
    chosen: Floats = values[rows]
    if name in ("status", "chart"):
        return chosen
    chosen = chosen.astype(np.float64)
    if name not in _FOR_LOST_POINTS_TOO:
        chosen[lost[rows]] = np.nan
    return chosen


def _cells(whole: Bools, rows: Bools) -> Ints:
    """Quads between four OK neighbours, in the order of the grid's corners."""
    number = np.full(rows.shape, -1)
    number[rows] = np.arange(rows.sum())
    return np.stack([number[corner][whole] for corner in _CORNERS], axis=1).astype(np.int64)


def _facets(cells: Ints, tensor: Floats, *, outward: bool) -> Facets:
    """Cut quads (M, 4) into the triangles that the tensors (M, 2, 2, 2) belong to."""
    order = [[0, 1, 2], [0, 2, 3]] if outward else [[0, 2, 1], [0, 3, 2]]
    values, _ = principal(tensor.reshape(-1, 2, 2))
    return Facets(cells[:, order].reshape(-1, 3), principal_measures(values[:, 0], values[:, 1]))


def _is_outward(cells: Ints, tracked: TrackedSurface, rows: Bools) -> bool:
    """Whether most quads turn the way of the faces they lie on."""
    points, normals = tracked.reference[rows], tracked.reference_normal[rows]
    across = points[cells[:, 2]] - points[cells[:, 0]], points[cells[:, 3]] - points[cells[:, 1]]
    along_normal = np.sum(np.cross(*across) * normals[cells[:, 0]], axis=1)
    return bool(np.count_nonzero(along_normal < 0) <= len(cells) / 2)
