"""One row per measured point, with the arrays that users read."""

from typing import Any

import numpy as np

from shapemorph.core.arrays import Bools, Codes, Floats, Ints
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus
from shapemorph.core.surface import Alignment, StrainField, TrackedSurface
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.charts.ownership import Ownership
from shapemorph.methods.principal import hencky_of, stretch_of

_WITHIN_NOISE = 3.0  # standard deviations below which a value says nothing
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
        **_strains(field),
        "zncc": grid.zncc,
        "iterations": grid.iterations,
        "sigma_displacement": tracked.sigma_position,
        "sigma_E1": field.sigma_e1,
        "sigma_E2": field.sigma_e2,
    }
    lost = status != PointStatus.OK
    return Measurement(
        reference=tracked.reference[rows],
        cells=_cells(whole, rows, tracked),
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


def _on_page(points_px: Floats, left: Floats) -> Floats:
    """Positions in the picture of the page itself."""
    return points_px - np.stack([left, np.zeros_like(left)], axis=-1)


def _strains(field: StrainField) -> dict[str, Floats]:
    major, minor = hencky_of(field.e1), hencky_of(field.e2)
    clear = np.abs(field.e2) > _WITHIN_NOISE * field.sigma_e2
    return {
        "E1": field.e1,
        "E2": field.e2,
        "hencky_1": major,
        "hencky_2": minor,
        "stretch_1": stretch_of(field.e1),
        "stretch_2": stretch_of(field.e2),
        "direction_1": field.direction_1,
        "direction_1_deformed": field.direction_1_deformed,
        "thickness_strain": -(major + minor),
        "anisotropy": field.e1 / np.where(clear & (field.e2 != 0), field.e2, np.nan),
    }


def _rows_of(name: str, values: Any, rows: Bools, lost: Bools) -> Floats:
    chosen: Floats = values[rows]
    if name in ("status", "chart"):
        return chosen
    chosen = chosen.astype(np.float64)
    if name not in _FOR_LOST_POINTS_TOO:
        chosen[lost[rows]] = np.nan
    return chosen


def _cells(whole: Bools, rows: Bools, tracked: TrackedSurface) -> Ints:
    """Quads between four OK neighbours, counter-clockwise seen against their normals."""
    number = np.full(rows.shape, -1)
    number[rows] = np.arange(rows.sum())
    cells = np.stack([number[corner][whole] for corner in _CORNERS], axis=1).astype(np.int64)
    return cells if _is_outward(cells, tracked, rows) else cells[:, ::-1].copy()


def _is_outward(cells: Ints, tracked: TrackedSurface, rows: Bools) -> bool:
    """Whether most quads turn the way of the faces they lie on."""
    points, normals = tracked.reference[rows], tracked.reference_normal[rows]
    across = points[cells[:, 2]] - points[cells[:, 0]], points[cells[:, 3]] - points[cells[:, 1]]
    along_normal = np.sum(np.cross(*across) * normals[cells[:, 0]], axis=1)
    return bool(np.count_nonzero(along_normal < 0) <= len(cells) / 2)
