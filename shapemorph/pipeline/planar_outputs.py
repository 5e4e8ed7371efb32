"""What is written of a correlation between two pictures."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from shapemorph.config import RunConfig
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Matches
from shapemorph.core.planar import PlanarStrain
from shapemorph.io.safe_files import write_json
from shapemorph.pipeline.run_facts import run_figures
from shapemorph.pipeline.summary import correlation_figures, matching_figures, point_figures, spread
from shapemorph.pipeline.verdict import judge


@dataclass(frozen=True, slots=True, eq=False)
class PlanarField:
    """What was found between two pictures.

    Attributes
    ----------
    reference : GreyImage
        With the mask of what was measured.
    grid : CorrelationGrid
    strain : PlanarStrain
    matches : Matches or None
        None where no features had to be matched.
    inputs : mapping
        How the pictures were read, for the summary.
    """

    reference: GreyImage
    grid: CorrelationGrid
    strain: PlanarStrain
    matches: Matches | None
    inputs: Mapping[str, Any] = dataclasses.field(default_factory=dict)


def write_field(folder: Path, field: PlanarField, config: RunConfig) -> None:
    """Write the table as CSV and NPZ, and the figures unless they are switched off."""
    from shapemorph.io.correlation_files import write_correlation

    write_correlation(folder, field.grid, field.strain)
    if config.report.figures:
        from shapemorph.view.planar import write_planar_figures

        write_planar_figures(
            field.grid, field.strain, field.reference, folder / "figures", config.report.theme
        )


def write_field_summary(
    folder: Path, field: PlanarField, config: RunConfig, seconds: Mapping[str, float]
) -> dict[str, Any]:
    """Write summary.json; return what stands in it."""
    sections: dict[str, Any] = {"inputs": dict(field.inputs)} if field.inputs else {}
    sections["points"] = point_figures(field.grid.status)
    if field.matches is not None:
        sections["match"] = matching_figures(field.matches)
    else:
        sections["match"] = {"manner": "no features needed: the pictures lie near each other"}
    sections["correlate"] = correlation_figures(field.grid, config.correlate, field.reference)
    sections["displacement_px"] = _displacement(field.grid)
    sections["strain"] = strain_figures(field.strain)
    sections |= run_figures(seconds)
    summary = {"verdict": judge(sections), **sections}
    write_json(folder / "summary.json", summary)
    return summary


def strain_figures(strain: PlanarStrain) -> dict[str, Any]:
    """Describe the strain and the gauge that it was measured with."""
    return {
        "measure": "Green-Lagrange",
        "window_points": strain.window,
        "gauge": "(window - 1) * spacing + subset size",
        "gauge_px": strain.gauge_px,
        "E_xx": spread(strain.green[..., 0, 0]),
        "E_xy": spread(strain.green[..., 0, 1]),
        "E_yy": spread(strain.green[..., 1, 1]),
        "E1": spread(strain.green_principal[..., 0]),
        "E2": spread(strain.green_principal[..., 1]),
    }


def _displacement(grid: CorrelationGrid) -> dict[str, Any]:
    moved = grid.deformed_px - grid.reference_px
    return {"u": spread(moved[..., 0]), "v": spread(moved[..., 1])}
