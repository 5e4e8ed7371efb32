"""How far each method goes: errors over the stretch of the twin and over the noise."""

import logging
import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.config import ReproduceConfig, RunConfig
from shapemorph.core.camera import Rig
from shapemorph.core.errors import ShapemorphError
from shapemorph.core.laws import LawInputs
from shapemorph.core.status import PointStatus
from shapemorph.core.stereo_track import StereoGrids
from shapemorph.core.stereo_twin import StereoTwin
from shapemorph.core.surface import Alignment
from shapemorph.io.measurement_files import read_vtp
from shapemorph.methods.twin_errors import TwinPoints, twin_points
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.picture_match import follow_pictures
from shapemorph.pipeline.stereo_inputs import stereo_sequence

METHODS = ("incremental", "image_morphing", "shape_morphing")
PAPER_METHODS = ("incremental", "image_morphing")
log = logging.getLogger(__name__)


def silent(event: Any) -> None:
    """Listen to nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Limit:
    """How well a method does at a state or with noise.

    Attributes
    ----------
    method : str
    at : float
        Largest stretch of the state, or noise in levels of 255.
    error : float
        Root mean square over u, v, w, mm; NaN where nothing was found.
    share : float
        Of the points that have a value.
    """

    method: str
    at: float
    error: float
    share: float


def settings_of(config: ReproduceConfig, twin: Path, method: str, *, paper: bool) -> RunConfig:
    """Give the configuration of one run over the pictures of the twin."""
    inputs = {
        "left": twin / "left_*.png",
        "right": twin / "right_*.png",
        "rig": twin / "rig.json",
        "region": {"mask": twin / "mask_left.png"},
    }
    ours = {"order": 2, "subset_size": config.subset_size, "spacing": config.spacing}
    correlate = {"mode": "paper", "spacing": config.spacing} if paper else ours
    match, morph = ({"ratio": 0.816}, {"images": 6}) if paper else ({}, {})
    report = {"figures": config.figures and method == "shape_morphing"}
    return RunConfig.model_validate(
        {
            "inputs": inputs,
            "track": {"method": method},
            "match": match,
            "morph": morph,
            "correlate": correlate,
            "report": report,
        }
    )


def runs_of(config: ReproduceConfig, twin: Path) -> dict[str, RunConfig]:
    """Give the configuration of every case: our own by method, the paper's with its name."""
    runs = {method: settings_of(config, twin, method, paper=False) for method in METHODS}
    if config.paper:
        for method in PAPER_METHODS:
            runs[f"paper_{method}"] = settings_of(config, twin, method, paper=True)
    return runs


def settings_by_case(config: ReproduceConfig, twin: Path) -> dict[str, dict[str, Any]]:
    """Name the settings in which ours and the paper's differ."""
    table = {}
    for name, run in runs_of(config, twin).items():
        correlate, paper = run.correlate, run.correlate.mode == "paper"
        bridged = run.track.method == "image_morphing"
        table[name] = {
            "criterion": "NCC" if paper else "ZNSSD",
            "solver": f"{'SQP' if paper else 'IC-GN'} to {correlate.tolerance:g} px",
            "shape_function": 1 if paper else correlate.order,
            "subset_px": correlate.subset_size,
            "spacing_px": correlate.spacing,
            "search_px": correlate.search if paper or bridged else None,
            "match_ratio": None if run.track.method == "incremental" else run.match.ratio,
            "synthetic_images": (run.morph.images if paper else 2) if bridged else None,
        }
    return table


def points_of(run: Path, twin: StereoTwin, rig: Rig, state: int) -> TwinPoints:
    """Read what a run has measured, with the truth about it."""
    measurement, _ = read_vtp(run / "measurement.vtp")
    return twin_points(twin, measurement, rig, state)


def limits_over_stretch(
    config: ReproduceConfig, twin: StereoTwin, pictures: Path, folder: Path
) -> list[Limit]:
    """Try every method up to some states; direct correlation as the first."""
    last = len(twin.maps) - 1
    states = sorted({round(s) for s in np.linspace(0, last, config.states + 1)[1:]})
    found = []
    for state in states:
        found.append(direct_correlation(config, twin, pictures, state))
        for method in METHODS:
            run = _until(config, pictures, method, state)
            found.append(_tried(method, run, twin, state, folder / "limits", _stretch(twin, state)))
    return found


def _until(config: ReproduceConfig, pictures: Path, method: str, state: int) -> RunConfig:
    """Name the states up to one; only the two ends for all but incremental."""
    run = settings_of(config, pictures, method, paper=False)
    numbers = range(state + 1) if method == "incremental" else (0, state)
    inputs = {side: _pattern(pictures, side, numbers) for side in ("left", "right")}
    return run.model_copy(
        update={
            "inputs": run.inputs.model_copy(update=inputs),
            "report": run.report.model_copy(update={"figures": False}),
        }
    )


def direct_correlation(
    config: ReproduceConfig, twin: StereoTwin, pictures: Path, state: int
) -> Limit:
    """Correlate the last pictures with the first as they are, from neighbour to neighbour.

    Between the views of the first state, which are alike, as ever.
    """
    from shapemorph.methods.assemble import assemble_measurement
    from shapemorph.methods.cameras.stereo_surface import stereo_surface
    from shapemorph.methods.charts.ownership import one_page
    from shapemorph.methods.increments import compose_grids
    from shapemorph.stages.strain import strain

    run = _until(config, pictures, "image_morphing", state)
    correlate = run.correlate.model_copy(update={"seeds": "propagate", "refinements": 0})
    near = run.model_copy(update={"correlate": correlate})
    sequence, clock = stereo_sequence(run), Clock(silent)
    first, at = sequence.first(), _stretch(twin, state)
    right = [sequence.picture("right", number) for number in (0, 1)]
    try:
        across = follow_pictures(first, right[0], run, LawInputs(), clock).grid
        left = follow_pictures(first, sequence.picture("left", 1), near, LawInputs(), clock).grid
        later = follow_pictures(right[0], right[1], near, LawInputs(), clock).grid
        grids = StereoGrids(across, left, compose_grids(across, later, shown=right[1].mask))
        tracked = stereo_surface(twin.rig, grids)
        field = strain(tracked, grids.left, run.strain)
    except ShapemorphError as error:
        log.info("direct correlation finds nothing at %g: %s", at, error)
        return Limit("direct", at, float("nan"), 0.0)
    pages = one_page(tracked.status.shape)
    found = assemble_measurement(grids.left, tracked, Alignment.unmoved(), field, pages)
    share = float((found.arrays["status"] == PointStatus.OK).mean())
    return Limit("direct", at, rms_of(twin_points(twin, found, twin.rig, state)), share)


def rms_of(points: TwinPoints) -> float:
    """Root mean square length of the errors, mm."""
    return float(np.sqrt((points.error**2).sum(axis=1).mean()))


def _pattern(pictures: Path, side: str, numbers: Iterable[int]) -> Path:
    """Put links to some pictures into a folder of their own, and name them by a pattern."""
    chosen = pictures.parent / "limits" / "pictures" / f"{side}_{'_'.join(map(str, numbers))}"
    chosen.mkdir(parents=True, exist_ok=True)
    for number in numbers:
        name = f"{side}_{number:02d}.png"
        link = chosen / name
        if not link.exists():
            link.symlink_to((pictures / name).absolute())
    return chosen / "*.png"


def _tried(
    method: str, run: RunConfig, twin: StereoTwin, state: int, folder: Path, at: float
) -> Limit:
    from shapemorph.pipeline.stereo_track import track_stereo

    place = folder / f"{method}_{state:02d}_{at:.3f}"
    try:
        outcome = track_stereo(run, place, listener=silent)
        points = points_of(place, twin, twin.rig, state)
    except ShapemorphError as error:
        log.info("%s finds nothing at %g: %s", method, at, error)
        return Limit(method, at, float("nan"), 0.0)
    return Limit(method, at, rms_of(points), outcome.summary["points"]["ok_share"])


def _stretch(twin: StereoTwin, state: int) -> float:
    """Largest principal stretch of a state."""
    from shapemorph.methods.synthetic.membrane.disc import disc_mesh
    from shapemorph.methods.synthetic.membrane.smooth import map_points

    material, _ = disc_mesh(0.95 * twin.radius, 40)
    slope = map_points(twin.maps[state], material)[1]
    return float(np.linalg.norm(slope, ord=2, axis=(1, 2)).max())


def limits_over_noise(
    config: ReproduceConfig, twin: StereoTwin, pictures: Path, folder: Path
) -> list[Limit]:
    """Try every method with further noise."""
    last, found = len(twin.maps) - 1, []
    for level in config.noises:
        noisy = folder / "limits" / f"noise_{level:g}"
        _add_noise(pictures, noisy, range(last + 1), level, config.twin.seed)
        total = float(np.hypot(level, config.twin.noise))
        for method in METHODS:
            run = settings_of(config, noisy, method, paper=False)
            report = run.report.model_copy(update={"figures": False})
            run = run.model_copy(update={"report": report})
            found.append(_tried(method, run, twin, last, folder / "limits", total))
    return found


def _add_noise(
    pictures: Path, folder: Path, states: Iterable[int], level: float, seed: int
) -> None:
    """Copy the pictures of some states, with noise; what lies beside them as it is."""
    from shapemorph.io.images import read_grey_image, write_grey_png
    from shapemorph.methods.synthetic.painting import record_grey

    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng([seed, round(1000 * level)])
    for state in states:
        for side in ("left", "right"):
            name = f"{side}_{state:02d}.png"
            image = read_grey_image(pictures / name)
            grey = record_grey(image.grey, noise=level, rng=rng)
            write_grey_png(folder / name, grey, np.ones_like(image.mask))
    for name in ("rig.json", "mask_left.png"):
        shutil.copyfile(pictures / name, folder / name)
