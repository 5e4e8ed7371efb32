"""The figures of a run: what `summary.json` holds and the command line prints."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from shapemorph.config import CorrelateConfig, RunConfig
from shapemorph.core.arrays import Codes, Floats
from shapemorph.core.flattened import FlattenedSurface
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.inputreports import InputReports
from shapemorph.core.matching import Matches
from shapemorph.core.measurement import Measurement
from shapemorph.core.results import RunResults
from shapemorph.core.status import PointStatus, count_statuses
from shapemorph.core.surface import Alignment, StrainField
from shapemorph.pipeline.run_facts import run_figures
from shapemorph.pipeline.systematic_figures import systematic_figures
from shapemorph.pipeline.verdict import judge

if TYPE_CHECKING:
    from shapemorph.methods.subset_choice import SubsetChoice

_SPREADS = (
    *("E1", "E2", "hencky_1", "hencky_2", "area_ratio", "thickness_strain", "thinning"),
    *("sigma_E1", "sigma_E2", "sigma_thickness_strain"),
)
_DIRECTIONS = (
    "{:.1%} of the points have none: E1 - E2 is within 3 sigma there, noise drives the two "
    "values apart, and their sigmas hold for the tensor in fixed axes only"
)


def summarise(
    results: RunResults, reports: InputReports, config: RunConfig, seconds: Mapping[str, float]
) -> dict[str, Any]:
    """Collect the figures of a measurement, JSON-able; NaN where a figure has no value."""
    arrays = results.measurement.arrays
    coverage = measured_share(results)
    sections: dict[str, Any] = {
        "points": point_figures(arrays["status"].astype(np.uint8)),
        "coverage": coverage,
        "displacement_mm": spread(np.linalg.norm(arrays["displacement"], axis=-1)),
        "sigma_displacement_mm": spread(arrays["sigma_displacement"]),
        "inputs": asdict(reports),
        "flatten": {
            "reference": flattening_figures(results.pair.reference),
            "deformed": flattening_figures(results.pair.deformed),
        },
        "match": matching_figures(results.matches),
        "morph": {"law": config.morph.law, "matches_instead_of_law": results.morphed.overruled},
        "correlate": correlation_figures(
            results.grid, config.correlate, results.pair.reference.calibrated.image
        ),
        "lift": {"mesh_noise_mm": results.tracked.mesh_noise.tolist()},
        "align": _alignment(results),
        "strain": _strain(results.field, results.measurement, results.grid.spacing),
        **({"forming": results.forming.figures} if results.forming.figures else {}),
        **systematic_figures(results.spread),
        **run_figures(seconds),
    }
    return {"verdict": judge(sections), "scorecard": _scorecard(sections), **sections}


def spread(values: Floats) -> dict[str, float]:
    """Give percentiles of what is not NaN."""
    finite = values[np.isfinite(values)]
    names = ("p1", "p5", "median", "p95", "p99")
    if finite.size == 0:
        return dict.fromkeys((*names, "max"), float("nan"))
    found = np.percentile(finite, [1, 5, 50, 95, 99])
    return {**dict(zip(names, found.tolist(), strict=True)), "max": float(finite.max())}


def flattening_figures(surface: FlattenedSurface) -> dict[str, Any]:
    """Describe how one surface was laid flat."""
    chart, distortion = surface.calibrated.chart, surface.distortion
    height, width = surface.calibrated.image.shape
    small = np.abs(distortion.sigma_2)
    with np.errstate(divide="ignore"):
        anisotropy, magnification = distortion.sigma_1 / small, np.sqrt(distortion.sigma_1 * small)
    return {
        "method": surface.method,
        "reason": surface.reason,
        "px_per_mm": chart.px_per_mm,
        "width_px": width,
        "height_px": height,
        "speckle_px": surface.speckle_px,
        "speckle_mm": surface.speckle_mm,
        "texels_per_px": surface.texels_per_px,
        "flips": distortion.flips,
        "local_px_per_mm": spread(magnification),
        "anisotropy": spread(anisotropy),
    }


def matching_figures(matches: Matches) -> dict[str, Any]:
    """Describe the matches and the warp through them."""
    from shapemorph.methods.second_tries import USUAL

    return {
        "pairs": len(matches.reference_px),
        "counts": dict(matches.counts),
        "residual_px": matches.residual_px,
        "settled_px": matches.settled_px,
        "fold_share": matches.fold_share,
        "doubt": matches.doubt,
        "manner": matches.manner or USUAL,
    }


def correlation_figures(
    grid: CorrelationGrid, config: CorrelateConfig, reference: GreyImage
) -> dict[str, Any]:
    """Describe the correlation: how it was set, how fast it was, how well it fits."""
    from shapemorph.methods.subset_choice import choose_subset

    choice = choose_subset(reference, subset_size=config.subset_size, spacing=config.spacing)
    ok = grid.status == PointStatus.OK
    return {
        "subset_size_px": grid.subset_size,
        "subset_reason": _why_subset(grid.subset_size, choice),
        "speckle_px": choice.speckle_px,
        "grey_noise": choice.grey_noise,
        "spacing_px": grid.spacing,
        "spacing_reason": _why_spacing(grid.spacing, choice.spacing, config),
        "order": config.order,
        "points_per_second": grid.ok_count / grid.kernel_seconds if grid.kernel_seconds else None,
        "kernel_seconds": grid.kernel_seconds,
        "zncc": spread(grid.zncc[ok]),
        "iterations": spread(grid.iterations[ok].astype(np.float64)),
        "sigma_px": spread(np.sqrt(np.mean(grid.sigma_px[ok] ** 2, axis=-1))),
    }


def _why_subset(size: int, choice: "SubsetChoice") -> str:
    if size == choice.subset_size:
        return choice.reason
    return (
        f"subset of {size} px, because the field bends within {choice.subset_size} "
        "px, the size for this speckle, by more than the shape function follows"
    )


def _why_spacing(spacing: int, usual: int, config: CorrelateConfig) -> str:
    if config.spacing is not None:
        return "as configured"
    if spacing >= usual:
        return "from the subset"
    return f"{usual} px would suit the subset; finer, because parts of the surface are shown small"


def measured_share(results: RunResults) -> dict[str, float]:
    """Measure how much of the reference surface the good points stand for.

    Each grid point stands for one cell of the grid; its area on the surface follows from
    the distortion of the triangle under it.

    Returns
    -------
    dict
        ``area_mm2`` of the good points, and its share of the points that were tried
        (``share_of_region``) and of the whole surface (``share_of_surface``). Cells at rims
        and seams reach a little too far; that never makes the second share the larger one.
    """
    surface = results.pair.reference
    area = _point_area(results.grid, surface).ravel()[results.measurement.grid_index]
    ok = results.measurement.arrays["status"] == PointStatus.OK
    good, region = float(np.nansum(area[ok])), float(np.nansum(area))
    home = surface.calibrated.chart.home
    whole = float(surface.distortion.area[slice(None) if home is None else home].sum())
    return {
        "area_mm2": good,
        "share_of_region": good / region if region else 0.0,
        "share_of_surface": good / max(whole, region) if whole else 0.0,
    }


def point_figures(status: Codes) -> dict[str, Any]:
    """Count the points inside the mask and what became of them."""
    counts = count_statuses(status)
    total = int((status != PointStatus.OUTSIDE_MASK).sum())
    ok = counts.get("OK", 0)
    return {"total": total, "ok": ok, "ok_share": ok / total if total else 0.0, "statuses": counts}


def _point_area(grid: CorrelationGrid, surface: FlattenedSurface) -> Floats:
    """(R, C) area on the surface of the cell around each point, mm^2; NaN off the surface."""
    triangle = surface.calibrated.triangle
    height, width = triangle.shape
    columns, rows = (grid.reference_px[..., axis].round().astype(np.int64) for axis in (0, 1))
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    under = np.where(inside, triangle[rows.clip(0, height - 1), columns.clip(0, width - 1)], -1)
    scale = surface.distortion.sigma_1 * np.abs(surface.distortion.sigma_2)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(under >= 0, grid.spacing**2 / scale[under], np.nan)


def _alignment(results: RunResults) -> dict[str, Any]:
    alignment: Alignment = results.alignment
    figures: dict[str, Any] = {
        "method": alignment.method,
        "note": alignment.note,
        "rms_mm": alignment.rms,
        "carried_by": alignment.carried_by,
        "carried_share": alignment.carried_share,
        "rotation": alignment.rotation.tolist(),
        "translation_mm": alignment.translation.tolist(),
    }
    if alignment.method.startswith("landmarks"):
        figures["landmark_residuals_mm"] = alignment.residuals.tolist()
    else:
        figures["residual_mm"] = spread(alignment.residuals)
    return figures


def _strain(field: StrainField, measurement: Measurement, spacing: int) -> dict[str, Any]:
    arrays = measurement.arrays
    mm_per_px = field.gauge_mm / field.gauge_px
    ok = arrays["status"] == PointStatus.OK
    isotropic = float(np.isnan(arrays["direction_1"][ok, 0]).mean()) if ok.any() else 0.0
    return {
        "measure": "Green-Lagrange",
        "window_points": field.window,
        "window_mm": (field.window - 1) * spacing * mm_per_px,
        "gauge": "(window - 1) * spacing + subset size",
        "gauge_px": field.gauge_px,
        "gauge_mm": field.gauge_mm,
        "facet_gauge_mm": (field.gauge_px - (field.window - 2) * spacing) * mm_per_px,
        "scatter_over_predicted": field.scatter,
        "share_without_direction": isotropic,
        "directions": _DIRECTIONS.format(isotropic),
        **{name: spread(arrays[name]) for name in _SPREADS},
    }


def _scorecard(sections: Mapping[str, Any]) -> dict[str, Any]:
    """Pick the dozen figures that a reader wants first."""
    strain, correlate = sections["strain"], sections["correlate"]
    margin = sections.get("forming", {}).get("diagram", {}).get("smallest_margin")
    return {
        "points with a value": sections["points"]["ok"],
        "share of points": sections["points"]["ok_share"],
        "share of surface": sections["coverage"]["share_of_surface"],
        "displacement median, mm": sections["displacement_mm"]["median"],
        "displacement max, mm": sections["displacement_mm"]["max"],
        "E1 median": strain["E1"]["median"],
        "E1 p99": strain["E1"]["p99"],
        "E2 median": strain["E2"]["median"],
        "thinning p99": strain["thinning"]["p99"],
        **({} if margin is None else {"limit margin, smallest": margin}),
        "sigma displacement median, mm": sections["sigma_displacement_mm"]["median"],
        "sigma E1 median": strain["sigma_E1"]["median"],
        "zncc median": correlate["zncc"]["median"],
        "zncc p5": correlate["zncc"]["p5"],
        "strain gauge, mm": strain["gauge_mm"],
        "alignment rms, mm": sections["align"]["rms_mm"],
        "points per second": correlate["points_per_second"],
    }
