"""What a forming laboratory asks for, gathered from a finished measurement."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from shapemorph.config import CutConfig, RunConfig
from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import StageError
from shapemorph.core.forming import Cut, Forming, LimitCurve
from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus


def with_forming(
    measurement: Measurement, config: RunConfig, curve: LimitCurve | None, mm_per_unit: float
) -> tuple[Measurement, Forming]:
    """Add arrays that only some ask for, and gather the rest.

    Parameters
    ----------
    measurement : Measurement
        With facets.
    config : RunConfig
        Its sections `strain` and `forming` say what is wanted.
    curve : LimitCurve or None
    mm_per_unit : float
        Of the reference file, in which sections are given.

    Raises
    ------
    StageError
        If the surface has no dome or a section misses it.
    """
    arrays, forming = dict(measurement.arrays), config.forming
    if config.strain.thickness is not None:
        arrays |= _thickness(arrays, config.strain.thickness)
    if curve is not None:
        arrays |= _margin(arrays, curve)
    full = replace(measurement, arrays=arrays)
    if not (forming.wants_diagram or forming.wants_dome or forming.sections):
        return full, Forming()
    figures: dict[str, Any] = {}
    critical = _critical(arrays, curve)
    cuts: tuple[Cut, ...] = ()
    if forming.wants_diagram:
        figures["diagram"] = _diagram(full, config, curve, critical)
    if forming.sections:
        cuts = tuple(_cut(full, cut, mm_per_unit) for cut in forming.sections)
        figures["sections"] = [_cut_figures(full, cut) for cut in cuts]
    if forming.wants_dome:
        figures["dome"] = _dome(full, config)
    return full, Forming(curve, forming.wants_diagram, critical, cuts, figures)


def corners_of(measurement: Measurement) -> Ints:
    """Triangles (T, 3) between points with a value."""
    if measurement.facets is None or not len(measurement.facets.corners):
        raise StageError("expected triangles between measured points, got none: lower spacing")
    return measurement.facets.corners


def carried(measurement: Measurement) -> Floats:
    """Deformed positions (N, 3) in the frame of the reference file, mm."""
    moved: Floats = measurement.reference + measurement.arrays["displacement"]
    return moved


def _thickness(arrays: dict[str, Floats], nominal: float) -> dict[str, Floats]:
    thickness = nominal * np.exp(arrays["thickness_strain"])
    noise = thickness * arrays["sigma_thickness_strain"]
    return {"thickness": thickness, "sigma_thickness": noise}


def _margin(arrays: dict[str, Floats], curve: LimitCurve) -> dict[str, Floats]:
    from shapemorph.methods.forming.limits import limit_margin, margin_noise

    minor, major = arrays["hencky_2"], arrays["hencky_1"]
    noise = [arrays[f"sigma_{k}"] for k in ("hencky_1", "hencky_2", "thickness_strain")]
    return {
        "limit_margin": limit_margin(curve, minor, major),
        "sigma_limit_margin": margin_noise(curve, minor, (noise[0], noise[1], noise[2])),
    }


def _critical(arrays: dict[str, Floats], curve: LimitCurve | None) -> int | None:
    """Row of the smallest margin; without a curve of the largest major strain."""
    danger = arrays["hencky_1"] if curve is None else -arrays["limit_margin"]
    return int(np.nanargmax(danger)) if np.isfinite(danger).any() else None


def _diagram(
    measurement: Measurement, config: RunConfig, curve: LimitCurve | None, critical: int | None
) -> dict[str, Any]:
    from shapemorph.methods.forming.limits import caveats

    arrays, forming = measurement.arrays, config.forming
    found: dict[str, Any] = {
        "measure": "Hencky (true) strain, in the tangent plane",
        "criterion": "largest eps1" if curve is None else "smallest margin, limit(eps2) - eps1",
        "critical_point": None if critical is None else _point(measurement, critical),
    }
    if curve is None:
        return found
    margin, ok = arrays["limit_margin"], arrays["status"] == PointStatus.OK
    known = np.isfinite(margin)
    beyond = arrays["hencky_1"][ok & ~known]
    return found | {
        "limit_curve": forming.limit_curve.name if forming.limit_curve else None,
        "curve_conditions": dict(curve.conditions),
        "caveats": [
            *caveats(
                curve,
                material=forming.material,
                thickness=config.strain.thickness,
                temperature=forming.temperature,
            ),
            *_caveat_of_ends(beyond, None if critical is None else arrays["hencky_1"][critical]),
        ],
        "smallest_margin": float(np.nanmin(margin)) if known.any() else None,
        "points_above_curve": int((margin < 0).sum()),
        "points_beyond_ends_of_curve": len(beyond),
    }


def _caveat_of_ends(beyond: Floats, critical: float | None) -> list[str]:
    """Give a sentence where points that the curve does not reach are strained most of all."""
    largest = np.nanmax(beyond, initial=-np.inf)
    if not largest > (0.0 if critical is None else critical):
        return []
    told = "none has a margin" if critical is None else f"the most critical one has {critical:.3g}"
    return [
        f"strain: {len(beyond)} points lie beyond the ends of the curve, with eps1 up to "
        f"{largest:.3g} where {told}: it says nothing about them"
    ]


def _point(measurement: Measurement, row: int) -> dict[str, Any]:
    names = ("hencky_1", "hencky_2", "thinning", "thickness", "limit_margin", "sigma_limit_margin")
    return {
        "row": row,
        "reference_mm": measurement.reference[row].tolist(),
        "deformed_mm": measurement.arrays["deformed_position"][row].tolist(),
        **{
            name: float(measurement.arrays[name][row])
            for name in names
            if name in measurement.arrays
        },
    }


def _cut(measurement: Measurement, config: CutConfig, mm_per_unit: float) -> Cut:
    from shapemorph.methods.forming.cuts import cut_surface, middle_of, plane_of

    corners = corners_of(measurement)
    plane = plane_of(
        middle_of(measurement.reference, corners),
        None if config.point is None else mm_per_unit * np.array(config.point),
        None if config.normal is None else np.array(config.normal),
        math.radians(config.angle or 0.0),
    )
    cut = cut_surface(config.name, measurement.reference, corners, plane)
    if not len(cut.share):
        raise StageError(
            f"section {config.name} misses what was measured: give a point of the surface, in the "
            "units and the frame of the reference file"
        )
    return cut


def cut_table(measurement: Measurement, cut: Cut) -> dict[str, Floats]:
    """Columns of the table of a cut.

    Returns
    -------
    dict of str to (K,) float64
        `line` counts the lines of the cut, `arc_mm` follows the reference along each,
        `along_mm` is measured from the point of the plane; then the columns of
        measurement.csv that a point between two others can have.
    """
    from shapemorph.io.measurement_files import table_columns

    places = cut.along_cut(measurement.reference)
    step = np.linalg.norm(np.diff(places, axis=0, prepend=places[:1]), axis=1)
    step[cut.starts] = 0.0
    arc = np.cumsum(step)
    line = np.cumsum(cut.starts)
    arc = arc - arc[cut.starts][line - 1]
    left_out = {"status", "chart", "iterations"}
    between = {
        name: cut.along_cut(values)
        for name, values in table_columns(measurement).items()
        if name not in left_out and not name.endswith("_px")
    }
    along = (places - cut.plane.point) @ cut.plane.along
    return {"line": line.astype(np.float64), "arc_mm": arc, "along_mm": along, **between}


def _cut_figures(measurement: Measurement, cut: Cut) -> dict[str, Any]:
    table = cut_table(measurement, cut)
    return {
        "name": cut.name,
        "point_mm": cut.plane.point.tolist(),
        "normal": cut.plane.normal.tolist(),
        "along": cut.plane.along.tolist(),
        "lines": int(cut.starts.sum()),
        "points": len(cut.share),
        "length_mm": float(sum(table["arc_mm"][table["line"] == k].max() for k in _lines(cut))),
    }


def _lines(cut: Cut) -> range:
    return range(1, int(cut.starts.sum()) + 1)


def _dome(measurement: Measurement, config: RunConfig) -> dict[str, Any]:
    from shapemorph.methods.forming.dome import measure_dome, membrane_stress, value_at_pole

    places = carried(measurement)
    dome = measure_dome(places, corners_of(measurement), cap=config.forming.cap)
    found: dict[str, Any] = {
        "height_mm": dome.height,
        "base": "plane fitted to the rim of what was measured",
        "rim_scatter_mm": dome.rim_scatter,
        "pole": _point(measurement, dome.pole),
        "pole_radius_mm": dome.radius,
        "sigma_pole_radius_mm": dome.sigma_radius,
        "principal_radii_mm": (1 / dome.curvatures).tolist(),
        "cap_mm": dome.cap,
        "cap_points": int(dome.in_cap.sum()),
    }
    if "thickness" in measurement.arrays:
        found["pole_thickness_mm"] = value_at_pole(dome, places, measurement.arrays["thickness"])
    if config.forming.pressure is not None:
        stress = membrane_stress(config.forming.pressure, dome.radius, found["pole_thickness_mm"])
        found |= {
            "pressure_MPa": config.forming.pressure,
            "membrane_stress_MPa": stress,
            "membrane_stress": "p R / (2 t) of a thin sphere; R of the surface as measured",
        }
    return found
