"""Measure what two cameras saw over time: one grid through all pictures, then space and strain."""

import json
import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.config import RunConfig
from shapemorph.core.errors import ConfigError
from shapemorph.core.image import GreyImage
from shapemorph.core.measurement import Measurement
from shapemorph.core.stereo_track import StereoGrids
from shapemorph.core.surface import Alignment, StrainField, TrackedSurface
from shapemorph.io.config_files import config_text
from shapemorph.io.safe_files import check_writable, move_files, scratch_folder, write_json
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.pictures import with_sizes
from shapemorph.pipeline.planar import PictureOutcome
from shapemorph.pipeline.run import Listener
from shapemorph.pipeline.run_facts import run_figures
from shapemorph.pipeline.stereo_inputs import StereoSequence, stereo_sequence
from shapemorph.pipeline.stereo_methods import follow_by_morphing, follow_incrementally
from shapemorph.pipeline.stereo_shapes import measure_shapes
from shapemorph.pipeline.summary import correlation_figures, point_figures, spread
from shapemorph.pipeline.verdict import judge

log = logging.getLogger(__name__)
STRAINS = ("E1", "E2", "hencky_1", "hencky_2", "thickness_strain", "sigma_E1", "sigma_E2")


@dataclass(frozen=True, slots=True, eq=False)
class StereoState:
    """What was measured of one state.

    Attributes
    ----------
    state : int
    grids : StereoGrids
    tracked : TrackedSurface
    field : StrainField
    measurement : Measurement
    """

    state: int
    grids: StereoGrids
    tracked: TrackedSurface
    field: StrainField
    measurement: Measurement


def track_stereo(config: RunConfig, folder: Path, *, listener: Listener) -> PictureOutcome:
    """Follow the points of the first left picture through a stereo sequence.

    Parameters
    ----------
    config : RunConfig
        `inputs.left`, `inputs.right`, `inputs.rig`; `track.method`; sections match, morph,
        correlate and strain. For shape_morphing see
        :func:`~shapemorph.pipeline.stereo_shapes.measure_shapes`.
    folder : Path
        Gets measurement.vtp, .csv and .glb, run.yaml, summary.json, report.html and, unless
        `report.figures` is off, figures/; with `track.temporal` frames/ with one surface a state
        and measurement.pvd over them.

    Raises
    ------
    ConfigError, DataError, StageError
        Nothing is written then.
    """
    if config.track.method == "shape_morphing":
        return measure_shapes(config, folder, listener=listener)
    check_writable(folder)
    clock = Clock(listener)
    sequence = stereo_sequence(config)
    first = clock.run("read", sequence.first)
    config = with_sizes(config, first)
    with scratch_folder(folder) as scratch:
        last = None
        for found in follow_states(sequence, config, clock):
            if config.track.temporal:
                _write_frame(scratch, found)
            last = found
        if last is None:
            raise ConfigError("a stereo sequence needs two states or more")
        clock.run("write", lambda: _write(scratch, last, config))
        figures = []
        if config.report.figures:
            figures = clock.run("figures", lambda: _draw(scratch / "figures", last, first, config))
        summary = _summary(last, first, config, clock)
        write_json(scratch / "summary.json", summary)
        _write_report(scratch, last, summary, config, figures)
        files = move_files(scratch, folder)
        return PictureOutcome(folder, tuple(files), summary)


def follow_states(
    sequence: StereoSequence, config: RunConfig, clock: Clock
) -> Iterator[StereoState]:
    """Measure the last state, or with `track.temporal` every one.

    Raises
    ------
    ConfigError
        If the method is none for the pictures of two cameras.
    StageError
        If a picture cannot be matched.
    """
    every = config.track.temporal
    if config.track.method == "incremental":
        found = follow_incrementally(sequence, config, clock)
    elif config.track.method == "image_morphing":
        found = follow_by_morphing(sequence, config, clock, every_state=every)
    else:
        raise ConfigError(
            f"a grid goes through pictures by incremental or image_morphing, got "
            f"{config.track.method}: choose one of them"
        )
    for state, grids in found:
        if every or state == sequence.states - 1:
            yield _measured(state, grids, sequence, config, clock)


def _measured(
    state: int, grids: StereoGrids, sequence: StereoSequence, config: RunConfig, clock: Clock
) -> StereoState:
    from shapemorph.methods.assemble import assemble_measurement
    from shapemorph.methods.cameras.stereo_surface import stereo_surface
    from shapemorph.methods.charts.ownership import one_page
    from shapemorph.stages.strain import strain

    tracked = clock.run("triangulate", lambda: stereo_surface(sequence.rig, grids))
    field = clock.run("strain", lambda: strain(tracked, grids.left, config.strain))
    pages = one_page(tracked.status.shape)
    measurement = assemble_measurement(grids.left, tracked, Alignment.unmoved(), field, pages)
    return StereoState(state, grids, tracked, field, measurement)


def _write(scratch: Path, last: StereoState, config: RunConfig) -> None:
    from shapemorph.io.measurement_files import write_measurement

    write_measurement(scratch, last.measurement, json.dumps(config.model_dump(mode="json")))
    (scratch / "run.yaml").write_text(config_text(config), encoding="utf-8")


def _write_frame(scratch: Path, found: StereoState) -> None:
    from shapemorph.io.time_series import add_to_series

    add_to_series(scratch / "measurement.pvd", found.measurement, found.state)


def _draw(folder: Path, last: StereoState, first: GreyImage, config: RunConfig) -> list[Path]:
    """Draw the figures; their files."""
    from shapemorph.view.tracked import write_tracked_figures

    grid, theme = last.grids.left, config.report.theme
    write_tracked_figures(last.measurement, grid, first, folder, theme)
    return sorted(folder.iterdir())


def _write_report(
    scratch: Path,
    last: StereoState,
    summary: dict[str, Any],
    config: RunConfig,
    figures: list[Path],
) -> None:
    from shapemorph.view.report import Contents, write_report

    settings = {"config": config.model_dump(mode="json")}
    contents = Contents(summary | settings, figures, last.measurement, config.report.theme)
    write_report(contents, scratch / "report.html")


def _summary(
    last: StereoState, first: GreyImage, config: RunConfig, clock: Clock
) -> dict[str, Any]:
    arrays = last.measurement.arrays
    moved = arrays["displacement"]
    sections: dict[str, Any] = {
        "points": point_figures(arrays["status"].astype(np.uint8)),
        "track": {"method": config.track.method, "state": last.state},
        "displacement_mm": spread(np.linalg.norm(moved, axis=-1)),
        "components_mm": {name: spread(moved[:, k]) for k, name in enumerate("uvw")},
        "sigma_displacement_mm": spread(arrays["sigma_displacement"]),
        "correlate": correlation_figures(last.grids.left, config.correlate, first),
        "strain": {
            "measure": "Green-Lagrange",
            "window_points": last.field.window,
            "gauge_px": last.field.gauge_px,
            "gauge_mm": last.field.gauge_mm,
            **{name: spread(arrays[name]) for name in STRAINS},
        },
        **run_figures(clock.seconds),
    }
    return {"verdict": judge(sections), **sections}
