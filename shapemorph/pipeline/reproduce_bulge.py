"""The paper's second experiment as a synthetic twin: from photographs all around to strain."""

import json
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.config import BulgeConfig, RunConfig
from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.errors import ShapemorphError
from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus
from shapemorph.core.turn_twin import TurnTwin
from shapemorph.io.measurement_files import read_vtp
from shapemorph.io.safe_files import check_writable, whole_file, write_json
from shapemorph.methods.synthetic.membrane.smooth import map_points
from shapemorph.methods.twin_errors import TwinPoints, error_figures, points_of_sheet
from shapemorph.pipeline.bulge_shapes import (
    calibrate_state,
    dots_in_pictures,
    glare_on,
    noisy_frames,
    shape_of_state,
)
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.reproduce_limits import Limit, log, silent
from shapemorph.pipeline.run import Listener
from shapemorph.pipeline.turntable import STATES, write_turntable_case

QUICK_BULGE: dict[str, Any] = {
    "twin": {"scale": 0.25, "frames": 18, "rings": 16},
    "patches": 18,
    "spacing": 4,
    "noises": (6.0,),
}
CLEAR = 0.88  # of the radius of the die: beyond it the sheet bends over the edge


@dataclass(frozen=True, slots=True, eq=False)
class LawCase:
    """Both shapes measured with one law.

    Attributes
    ----------
    folder : Path
        Of the run.
    measurement : Measurement
    points : TwinPoints
        In the frame of the die.
    position : (N, 3) float64
        Measured less true position after, mm: nothing is aligned in it.
    seconds : float
    """

    folder: Path
    measurement: Measurement
    points: TwinPoints
    position: Floats
    seconds: float

    @property
    def clear(self) -> Bools:
        """Points (N,) away from the kink at the edge of the die."""
        return _is_clear(self.points.material)


@dataclass(frozen=True, slots=True, eq=False)
class BulgeReproduction:
    """Everything that the page shows.

    Attributes
    ----------
    twin : TurnTwin
    folder : Path
        Of the page; twin/ and shapes/ lie in it.
    config : BulgeConfig
    laws : dict of str to LawCase
        The main law first.
    over_noise : list of Limit
    """

    twin: TurnTwin
    folder: Path
    config: BulgeConfig
    laws: dict[str, LawCase]
    over_noise: list[Limit]


def reproduce_bulge(config: BulgeConfig, folder: Path, *, listener: Listener) -> dict[str, Any]:
    """Photograph the bulge from all sides, reconstruct and measure it, and write the page.

    Parameters
    ----------
    config : BulgeConfig
    folder : Path
        Gets index.html, summary.json, errors.csv, figures/, twin/, shapes/ and a run of each
        law.

    Returns
    -------
    dict
        What summary.json holds.

    Raises
    ------
    ConfigError, StageError
    """
    from shapemorph.pipeline.reproduce_bulge_page import write_bulge_page

    check_writable(folder)
    clock, pictures = Clock(listener), folder / "twin"
    twin, _ = clock.run(
        "twin", lambda: write_turntable_case(config.twin, pictures, listener=silent)
    )
    shapes = {}
    for state in STATES:
        clock.run(f"calibrate {state}", partial(calibrate_state, pictures / state))
        place = folder / "shapes" / state
        rebuild = partial(shape_of_state, config, pictures, state, place)
        shapes[state] = clock.run(f"reconstruct {state}", rebuild)
    laws: dict[str, LawCase] = {}
    for law in config.laws:
        run = measurement_of(config, pictures, shapes, law)
        laws[law] = clock.run(f"law {law}", partial(_case, run, twin, folder / f"law_{law}"))
    noisy = [_limit(config.twin.noise, laws[config.laws[0]])]
    for level in config.noises:
        repeat = partial(_with_noise, config, twin, folder, level)
        noisy.append(clock.run(f"noise {level:g}", repeat))
    found = BulgeReproduction(twin, folder, config, laws, noisy)
    summary = clock.run("summary", lambda: _summary(found, clock))
    write_json(folder / "summary.json", summary)
    _write_table(folder / "errors.csv", summary)
    clock.run("page", lambda: write_bulge_page(found, summary))
    return summary


def measurement_of(
    config: BulgeConfig, pictures: Path, shapes: dict[str, Path], law: str
) -> RunConfig:
    """Give the configuration that measures both shapes with one law.

    The first law draws the figures and tells how far the others lead.
    """
    first = law == config.laws[0]
    morph: dict[str, Any] = {"law": law, "fe": pictures / "law.csv"}
    if first:
        morph["laws"] = config.laws[1:]
    document = {
        "inputs": {
            "reference": shapes["before"],
            "deformed": shapes["after"],
            "landmarks": pictures / "landmarks.csv",
        },
        "flatten": {"charts": 1},  # the laws are told about one picture
        "morph": morph,
        "correlate": {"order": 2},
        "report": {"figures": config.figures and first},
    }
    run = RunConfig.model_validate(document)
    if "landmarks" not in run.morph.all_laws:
        return run
    dots = dots_in_pictures(run, pictures / "dots.csv", shapes["after"].parent)
    return run.model_copy(update={"morph": run.morph.model_copy(update={"dots": dots})})


def _case(run: RunConfig, twin: TurnTwin, folder: Path) -> LawCase:
    from shapemorph.pipeline.measure import measure

    measure(run, folder, listener=silent)
    measurement, _ = read_vtp(folder / "measurement.vtp")
    points = points_of_sheet(twin.maps, measurement, twin.placed[0].inverse())
    ok = measurement.arrays["status"] == PointStatus.OK
    true = twin.placed[1].apply(map_points(twin.maps[1], points.material)[0])
    position = measurement.arrays["deformed_position"][ok] - true
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return LawCase(folder, measurement, points, position, summary["seconds"]["total"])


def _limit(noise: float, case: LawCase) -> Limit:
    ok = case.measurement.arrays["status"] == PointStatus.OK
    return Limit("shape_morphing", noise, _rms(case.position[case.clear]), float(ok.mean()))


def _with_noise(config: BulgeConfig, twin: TurnTwin, folder: Path, level: float) -> Limit:
    """Repeat everything after the calibration with noise in the photographs."""
    total = float(np.hypot(level, config.twin.noise))
    place = folder / "limits" / f"noise_{level:g}"
    try:
        pictures = noisy_frames(folder / "twin", place, level, config.twin.seed)
        shapes = {
            state: shape_of_state(config, pictures, state, place / "shapes" / state)
            for state in STATES
        }
        quiet = config.model_copy(update={"figures": False, "laws": config.laws[:1]})
        run = measurement_of(quiet, folder / "twin", shapes, config.laws[0])
        return _limit(total, _case(run, twin, place / "run"))
    except ShapemorphError as error:
        log.info("nothing is found with noise of %g levels: %s", total, error)
        return Limit("shape_morphing", total, float("nan"), 0.0)


def _summary(found: BulgeReproduction, clock: Clock) -> dict[str, Any]:
    laws = {name: _law_figures(case) for name, case in found.laws.items()}
    main = found.laws[found.config.laws[0]]
    run = json.loads((main.folder / "summary.json").read_text(encoding="utf-8"))
    return {
        "kind": "bulge",
        "laws": laws,
        "laws_agree_mm": run["systematic"]["position_rms_mm"] if len(laws) > 1 else None,
        "systematic": run.get("systematic"),
        "glare": _glare_figures(found, main),
        "over_noise": [
            {"noise_levels": row.at, "error_rms_mm": row.error, "share_of_points": row.share}
            for row in found.over_noise
        ],
        "shapes": {state: _shape_figures(found.folder / "shapes" / state) for state in STATES},
        "seconds": clock.seconds,
        "settings": json.loads(found.config.model_dump_json()),
    }


def _law_figures(case: LawCase) -> dict[str, Any]:
    clear, strain = case.clear, case.points.strain - case.points.true_strain
    return {
        "points": len(case.points.material),
        "points_away_from_kink": int(clear.sum()),
        "largest_E1": float(np.nanmax(case.points.strain[clear, 0])),
        "against_truth": error_figures(case.points),
        "rms_away_from_kink": {
            "position_mm": _rms(case.position[clear]),
            "displacement_mm": _rms(case.points.error[clear]),
            "E1": _rms(strain[clear, :1]),
            "E2": _rms(strain[clear, 1:]),
        },
        "seconds": case.seconds,
    }


def _glare_figures(found: BulgeReproduction, main: LawCase) -> dict[str, Any]:
    """Say what was found where glare lay in some of the photographs, and how well."""
    inverse = found.twin.placed[0].inverse()
    material = inverse.apply(main.measurement.reference)[:, :2]
    ok = main.measurement.arrays["status"] == PointStatus.OK
    covered = glare_on(found.twin, found.folder / "twin" / "after", material) & _is_clear(material)
    strain = main.points.strain[:, 0] - main.points.true_strain[:, 0]
    return {
        "points": int(covered.sum()),
        "share_found": float(ok[covered].mean()) if covered.any() else None,
        "rms_E1": _rms(strain[covered[ok]][:, None]),
        "rms_position_mm": _rms(main.position[covered[ok]]),
    }


def _shape_figures(folder: Path) -> dict[str, Any]:
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    chosen = ("points", "overlap_rms_mm", "views", "texture_px_per_mm", "mesh", "peak_memory_mb")
    return {name: summary[name] for name in chosen}


def _is_clear(material: Floats) -> Bools:
    from shapemorph.stages.turntable import DIE

    clear: Bools = np.linalg.norm(material, axis=1) < CLEAR * DIE
    return clear


def _rms(errors: Floats) -> float:
    """Root mean square length of rows (N, K), without NaN."""
    known = errors[np.isfinite(errors).all(axis=1)]
    return float(np.sqrt((known**2).sum(axis=1).mean())) if len(known) else float("nan")


def _write_table(path: Path, summary: dict[str, Any]) -> None:
    lines = ["law,quantity,mean,std,abs_mean_plus_std,largest"]
    for name, law in summary["laws"].items():
        for quantity, row in law["against_truth"].items():
            numbers = ",".join(f"{row[key]:.6g}" for key in ("mean", "std", "sum", "largest"))
            lines.append(f"{name},{quantity},{numbers}")
    with whole_file(path) as partial:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
