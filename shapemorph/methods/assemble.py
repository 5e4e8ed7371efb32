"""One row per measured point, with the arrays that users read."""

from typing import Any

import numpy as np

from shapemorph.core.arrays import Bools, Codes, Floats, Ints
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus
from shapemorph.core.surface import Alignment, StrainField, TrackedSurface
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.principal import hencky_of, stretch_of

_WITHIN_NOISE = 3.0  # standard deviations below which a value says nothing
_FOR_LOST_POINTS_TOO = {"status", "chart", "reference_px", "zncc", "iterations"}


def assemble_measurement(
    grid: CorrelationGrid, tracked: TrackedSurface, alignment: Alignment, field: StrainField
) -> Measurement:
    """Gather everything that was measured at the grid points inside the mask.

    Parameters
    ----------
    grid : CorrelationGrid
    tracked : TrackedSurface
    alignment : Alignment
    field : StrainField

    Returns
    -------
    Measurement
        Points that were followed but have no strain are DEGENERATE_FACET. Lost points
        keep their reference position, `reference_px`, `zncc` and `iterations`; everything
        else is NaN there.
    """
    status = _final_status(tracked, field)
    rows = status != PointStatus.OUTSIDE_MASK
    arrays: dict[str, Any] = {
        "status": status,
        "chart": np.zeros(status.shape, dtype=np.int64),
        **_positions(grid, tracked, alignment),
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
        cells=_cells(status, rows, tracked),
        arrays={name: _rows_of(name, values, rows, lost) for name, values in arrays.items()},
    )


def _final_status(tracked: TrackedSurface, field: StrainField) -> Codes:
    measured = np.isfinite(field.e1) & np.isfinite(field.e2)
    status = tracked.status.copy()
    status[(status == PointStatus.OK) & ~measured] = PointStatus.DEGENERATE_FACET
    return status


def _positions(
    grid: CorrelationGrid, tracked: TrackedSurface, alignment: Alignment
) -> dict[str, Floats]:
    reference_from_deformed = RigidTransform(alignment.rotation, alignment.translation)
    return {
        "deformed_position": tracked.deformed,
        "displacement": reference_from_deformed.apply(tracked.deformed) - tracked.reference,
        "reference_px": grid.reference_px,
        "deformed_px": grid.deformed_px,
    }


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


def _cells(status: Codes, rows: Bools, tracked: TrackedSurface) -> Ints:
    """Quads between four OK neighbours, counter-clockwise seen against their normals."""
    number = np.full(status.shape, -1)
    number[rows] = np.arange(rows.sum())
    corners = [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]]
    sound = status == PointStatus.OK
    whole = sound[:-1, :-1] & sound[:-1, 1:] & sound[1:, 1:] & sound[1:, :-1]
    cells = np.stack([corner[whole] for corner in corners], axis=1).astype(np.int64)
    return cells if _is_outward(cells, tracked, rows) else cells[:, ::-1].copy()


def _is_outward(cells: Ints, tracked: TrackedSurface, rows: Bools) -> bool:
    """Whether most quads turn the way of the faces they lie on."""
    points, normals = tracked.reference[rows], tracked.reference_normal[rows]
    across = points[cells[:, 2]] - points[cells[:, 0]], points[cells[:, 3]] - points[cells[:, 1]]
    along_normal = np.sum(np.cross(*across) * normals[cells[:, 0]], axis=1)
    return bool(np.count_nonzero(along_normal < 0) <= len(cells) / 2)
