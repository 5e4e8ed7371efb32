"""The paper's first experiment as a synthetic twin: all methods against the truth, on one page."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from shapemorph.config import BulgeConfig, ReproduceConfig, RunConfig, Section
from shapemorph.core.stereo_twin import StereoTwin
from shapemorph.io.safe_files import check_writable, whole_file, write_json
from shapemorph.methods.synthetic.stereo_rig import MM_PER_PX
from shapemorph.methods.twin_errors import TwinPoints, between_methods, error_figures
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.reproduce_limits import (
    METHODS,
    Limit,
    limits_over_noise,
    limits_over_stretch,
    points_of,
    rms_of,
    runs_of,
    settings_by_case,
    silent,
)
from shapemorph.pipeline.run import Listener

BENCHMARK = "incremental"
MOST_POINTS = 0.9  # share of the points with which a method is said to reach a stretch
QUICK: dict[str, Any] = {
    "twin": {"law": "analytic", "scale": 0.25, "steps": 4, "travel": 24.0, "views": 0},
    "spacing": 6,
    "noises": (8.0,),
    "states": 2,
    "paper": False,
}


class ReproduceFile(Section):
    """The YAML file of a reproduction: of the membrane, or of the bulge."""

    reproduce: ReproduceConfig = Field(ReproduceConfig(), description="what is measured, and how")
    bulge: BulgeConfig | None = Field(None, description="the bulge instead of the membrane")


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """One method with its settings on the twin.

    Attributes
    ----------
    name : str
    folder : Path
        Of the run.
    points : TwinPoints
    seconds, peak_memory_mb : float
    """

    name: str
    folder: Path
    points: TwinPoints
    seconds: float
    peak_memory_mb: float


@dataclass(frozen=True, slots=True, eq=False)
class Reproduction:
    """Everything that the page shows.

    Attributes
    ----------
    twin : StereoTwin
    twin_folder : Path
    config : ReproduceConfig
    cases : dict of str to Case
        Our own settings by method; the paper's as `paper_<method>`.
    over_stretch, over_noise : list of Limit
    """

    twin: StereoTwin
    twin_folder: Path
    config: ReproduceConfig
    cases: dict[str, Case]
    over_stretch: list[Limit]
    over_noise: list[Limit]


def reproduce_membrane(
    config: ReproduceConfig, folder: Path, *, listener: Listener
) -> dict[str, Any]:
    """Synthesise the membrane, measure it by every method, and write the page.

    Parameters
    ----------
    config : ReproduceConfig
    folder : Path
        Gets index.html, summary.json, errors.csv, figures/, twin/ and a run of each method.

    Returns
    -------
    dict
        What summary.json holds.

    Raises
    ------
    ConfigError, StageError
    """
    from shapemorph.io.twin_files import read_twin
    from shapemorph.pipeline.reproduce_page import write_page
    from shapemorph.pipeline.twin import write_twin_case

    check_writable(folder)
    clock, twin_folder = Clock(listener), folder / "twin"
    clock.run("twin", lambda: write_twin_case(config.twin, twin_folder, listener=silent))
    twin = read_twin(twin_folder / "truth.npz")
    cases = {}
    for name, run in runs_of(config, twin_folder).items():
        cases[name] = clock.run(name, lambda name=name, run=run: _case(name, run, twin, folder))  # type: ignore[misc]
    stretched = clock.run("limits", lambda: limits_over_stretch(config, twin, twin_folder, folder))
    noisy = [_as_it_is(cases[method], config.twin.noise) for method in METHODS]
    noisy += clock.run("noise", lambda: limits_over_noise(config, twin, twin_folder, folder))
    found = Reproduction(twin, twin_folder, config, cases, stretched, noisy)
    summary = _summary(found)
    write_json(folder / "summary.json", summary)
    _write_table(folder / "errors.csv", summary)
    clock.run("page", lambda: write_page(found, summary, folder))
    return summary


def _case(name: str, run: RunConfig, twin: StereoTwin, folder: Path) -> Case:
    from shapemorph.pipeline.stereo_track import track_stereo

    outcome = track_stereo(run, folder / name, listener=silent)
    points = points_of(folder / name, twin, twin.rig, len(twin.maps) - 1)
    seconds, memory = outcome.summary["seconds"]["total"], outcome.summary["peak_memory_mb"]
    return Case(name, folder / name, points, seconds, memory)


def _as_it_is(case: Case, noise: float) -> Limit:
    """Give the error with the noise that the pictures have of themselves."""
    summary = json.loads((case.folder / "summary.json").read_text(encoding="utf-8"))
    return Limit(case.name, noise, rms_of(case.points), summary["points"]["ok_share"])


def _summary(found: Reproduction) -> dict[str, Any]:
    benchmark = found.cases[BENCHMARK].points
    methods = {}
    for name, case in found.cases.items():
        methods[name] = {
            "points": len(case.points.material),
            "against_truth_mm": error_figures(case.points),
            "against_incremental_mm": None
            if name == BENCHMARK
            else between_methods(case.points, benchmark),
            "off_by_more_than_0.06_mm": int(
                np.count_nonzero(np.abs(case.points.error).max(axis=1) > 0.06)
            ),
            "seconds": case.seconds,
            "peak_memory_mb": case.peak_memory_mb,
        }
    limits = {
        "over_stretch": [_row(limit, "largest_stretch") for limit in found.over_stretch],
        "over_noise": [_row(limit, "noise_levels") for limit in found.over_noise],
    }
    settings = json.loads(found.config.model_dump_json())
    return {
        "kind": found.twin.kind,
        "methods": methods,
        **limits,
        "reach": _reach(found),
        "settings": settings,
        "settings_by_case": settings_by_case(found.config, found.twin_folder),
    }


def _reach(found: Reproduction) -> dict[str, float | None]:
    """Largest stretch up to which each method finds most points, and to a pixel."""
    pixel = MM_PER_PX / found.config.twin.scale
    reach: dict[str, float | None] = {}
    for limit in sorted(found.over_stretch, key=lambda limit: limit.at):
        reach.setdefault(limit.method, None)
        if limit.share >= MOST_POINTS and limit.error <= pixel:
            reach[limit.method] = limit.at
    return reach


def _row(limit: Limit, at: str) -> dict[str, Any]:
    return {
        "method": limit.method,
        at: limit.at,
        "error_rms_mm": limit.error,
        "share_of_points": limit.share,
    }


def _write_table(path: Path, summary: dict[str, Any]) -> None:
    lines = ["method,against,quantity,mean,std,abs_mean_plus_std,largest"]
    for name, method in summary["methods"].items():
        for against in ("truth", "incremental"):
            for quantity, row in (method[f"against_{against}_mm"] or {}).items():
                numbers = ",".join(f"{row[key]:.6g}" for key in ("mean", "std", "sum", "largest"))
                lines.append(f"{name},{against},{quantity},{numbers}")
    with whole_file(path) as partial:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
