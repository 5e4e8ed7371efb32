"""A sequence of pictures: one field for each, all of them on the grid of the first."""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from shapemorph.config import RunConfig
from shapemorph.core.errors import DataError, StageError
from shapemorph.core.image import GreyImage
from shapemorph.io.frames import Frame, read_frame
from shapemorph.io.safe_files import check_writable, move_files, scratch_folder, write_json
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.pictures import in_one_channel, limited, with_sizes
from shapemorph.pipeline.planar import PictureOutcome
from shapemorph.pipeline.planar_outputs import PlanarField, write_field, write_field_summary
from shapemorph.pipeline.run import Listener
from shapemorph.pipeline.run_facts import run_figures
from shapemorph.pipeline.tracking import Followed, Tracker
from shapemorph.pipeline.verdict import FAIL, WARN

DRIFT = 0.1  # px; more of it is worth a warning


@dataclass(frozen=True, slots=True)
class _Work:
    """What all frames share."""

    config: RunConfig
    scratch: Path
    clock: Clock
    inputs: dict[str, Any]


def correlate_frames(
    frames: Sequence[Frame],
    folder: Path,
    config: RunConfig,
    *,
    mask: Path | None,
    listener: Listener,
) -> PictureOutcome:
    """Follow the points of the first picture through all others, and write every field.

    Parameters
    ----------
    frames : sequence of Frame
        Two or more; the first is the reference.
    folder : Path
        Gets one folder a picture, frames.csv, summary.json and figures/frames.png.
    config : RunConfig
        `correlate.reference` says what each picture is compared with.
    mask : Path or None
        Picture of the size of the first one, white = measured.

    Raises
    ------
    ConfigError, DataError, StageError
        Nothing is written then. A picture in which nothing is found is no error unless it
        is so in all of them: its points are lost, and its row in the table says why.
    """
    check_writable(folder)
    clock = Clock(listener)
    reader = partial(read_frame, frames[0])
    (picture,), channel, reason = clock.run(
        "read", lambda: in_one_channel([reader], config.inputs.channel)
    )
    first = GreyImage(picture.grey, picture.opaque)
    first = limited(first, config.inputs.region, mask, frames[0].path)
    config = with_sizes(config, first)
    tracker = Tracker(frames[0].name, first, config)
    with scratch_folder(folder) as scratch:
        work = _Work(config, scratch, clock, {"channel": channel, "channel_reason": reason})
        rows = _follow_all(frames[1:], first, tracker, work)
        drift = clock.run("drift", tracker.drift)
        clock.run("write", lambda: _write_overview(rows, work))
        found = {
            "inputs": work.inputs,
            "frames": rows,
            "correlate": {"reference": config.correlate.reference},
            "drift": None if drift is None else asdict(drift),
            **run_figures(clock.seconds),
        }
        summary = {"verdict": _verdict(found), **found}
        write_json(scratch / "summary.json", summary)
        kept = [frame.path for frame in frames] + ([mask] if mask else [])
        files = move_files(scratch, folder, kept)
        return PictureOutcome(folder, tuple(files), summary)


def _follow_all(
    frames: Sequence[Frame], first: GreyImage, tracker: Tracker, work: _Work
) -> list[dict[str, Any]]:
    """Write the folder of each picture; return the rows of the table."""
    rows: list[dict[str, Any]] = []
    for frame in frames:
        begin = time.perf_counter()
        picture = _read(frame, work.inputs["channel"], first.shape)
        work_on = partial(_follow, tracker, frame, picture)
        followed = work.clock.run(f"correlate {frame.name}", work_on)
        field = _field(first, followed, work)
        summary = _write_frame(frame.name, field, work, time.perf_counter() - begin)
        rows.append(_row(frame.name, followed, summary))
    if not any(row["ok"] for row in rows):
        raise StageError(
            f"expected the pattern of the first picture in the others, got it in none of "
            f"{len(frames)}: {rows[-1]['reason']}"
        )
    return rows


def _read(frame: Frame, channel: str, shape: tuple[int, int]) -> GreyImage:
    read = read_frame(frame, channel)
    picture = GreyImage(read.grey, read.opaque)
    if picture.shape != shape:
        raise DataError(
            f"{frame.label}: expected {shape[1]} x {shape[0]} px like the first picture, got "
            f"{picture.shape[1]} x {picture.shape[0]} px: leave it out of the sequence"
        )
    return picture


def _follow(tracker: Tracker, frame: Frame, picture: GreyImage) -> Followed:
    try:
        return tracker.follow(frame.name, picture)
    except StageError as error:
        return tracker.nothing(str(error))


def _field(first: GreyImage, followed: Followed, work: _Work) -> PlanarField:
    from shapemorph.methods.planar_strain import planar_strain

    strain = planar_strain(followed.grid, window=work.config.strain.window)
    return PlanarField(first, followed.grid, strain, None, work.inputs)


def _write_frame(name: str, field: PlanarField, work: _Work, seconds: float) -> dict[str, Any]:
    """Write the folder of one picture; return its summary."""
    folder = work.scratch / name
    folder.mkdir()
    write_field(folder, field, work.config)
    return write_field_summary(folder, field, work.config, {"correlate": seconds})


def _row(name: str, followed: Followed, summary: dict[str, Any]) -> dict[str, Any]:
    points, correlate = summary["points"], summary["correlate"]
    moved, strain = summary["displacement_px"], summary["strain"]
    return {
        "frame": name,
        "reference": followed.reference,
        "features_matched": followed.matched,
        "points": points["total"],
        "ok": points["ok"],
        "ok_share": points["ok_share"],
        "zncc_median": correlate["zncc"]["median"],
        "u_median_px": moved["u"]["median"],
        "v_median_px": moved["v"]["median"],
        "E1_median": strain["E1"]["median"],
        "E1_p99": strain["E1"]["p99"],
        "E2_median": strain["E2"]["median"],
        "sigma_median_px": correlate["sigma_px"]["median"],
        "seconds": summary["seconds"]["total"],
        "verdict": summary["verdict"]["level"],
        "reason": followed.reason,
    }


def _write_overview(rows: list[dict[str, Any]], work: _Work) -> None:
    from shapemorph.io.frame_tables import write_frame_table

    write_frame_table(work.scratch / "frames.csv", rows)
    if work.config.report.figures:
        from shapemorph.view.frames import write_frames_figure

        write_frames_figure(rows, work.scratch / "figures", work.config.report.theme)


def _verdict(found: dict[str, Any]) -> dict[str, Any]:
    rows, reasons = found["frames"], []
    for level in (FAIL, WARN):
        doubted = [row["frame"] for row in rows if row["verdict"] == level]
        if doubted:
            names = ", ".join(doubted[:3]) + (", ..." if len(doubted) > 3 else "")
            reasons.append((level, f"{len(doubted)} of {len(rows)} pictures: {names}"))
    drift = found["drift"]
    if drift is not None and drift["rms_px"] > DRIFT:
        reasons.append(
            (
                WARN,
                f"displacements put together from increments have drifted by "
                f"{drift['rms_px']:.2g} px rms from those found in one step",
            )
        )
    levels = {level for level, _ in reasons}
    level = FAIL if FAIL in levels else WARN if WARN in levels else "PASS"
    return {"level": level, "reasons": [f"{level}: {text}" for level, text in reasons]}
