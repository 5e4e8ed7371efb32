"""From the pictures of a calibration to its files."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from shapemorph.config import RigConfig, ViewsConfig
from shapemorph.core.calibration import Calibration, Sighting, View
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.io.images import read_grey_image
from shapemorph.io.picture_sets import named_pictures
from shapemorph.io.rig_files import read_rig, write_exports, write_rig
from shapemorph.io.safe_files import check_writable, move_files, scratch_folder, write_json
from shapemorph.pipeline.calibration_summary import calibration_figures, write_residuals
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.planar import PictureOutcome
from shapemorph.pipeline.run import Listener
from shapemorph.pipeline.run_facts import run_figures
from shapemorph.stages.calibrate import Finder, calibrate, find_target, make_finder

CALIBRATION_FILE = "calibration.json"


@dataclass(frozen=True, slots=True)
class Shot:
    """One picture of a target: by which camera, in which view."""

    camera: int
    view: int
    path: Path
    anchors: tuple[tuple[int, int, float, float], ...]


@dataclass(slots=True)
class _Seen:
    """What was found in the pictures."""

    sightings: list[Sighting] = field(default_factory=list)
    rejected: list[tuple[str, str]] = field(default_factory=list)
    sizes: dict[int, tuple[int, int]] = field(default_factory=dict)


def calibrate_cameras(
    config: RigConfig, base: Path, folder: Path, *, listener: Listener
) -> PictureOutcome:
    """Calibrate the cameras of a rig from pictures of targets.

    Parameters
    ----------
    config : RigConfig
    base : Path
        Folder that the names of pictures are relative to.
    folder : Path
        Gets calibration.json, exports for other programs, residuals.csv, summary.json and
        figures.

    Raises
    ------
    ConfigError, DataError, StageError
        Nothing is written then.
    """
    check_writable(folder)
    clock = Clock(listener)
    finders = _finders(config, base)
    views, shots, notes = list_shots(config, base, finders)
    before = config.calibrate.before
    seen = _Seen(rejected=notes)
    for name, number in zip(config.cameras, range(len(config.cameras)), strict=True):
        mine = [shot for shot in shots if shot.camera == number]
        clock.run(f"find in {name}", lambda mine=mine: _find_all(mine, views, finders, seen))  # type: ignore[misc]
        _require_found(name, mine, number, seen)
    sizes = [seen.sizes[number] for number in range(len(config.cameras))]
    found = clock.run(
        "calibrate",
        lambda: calibrate(
            seen.sightings, views, sizes, config.cameras, seen.rejected, config.calibrate
        ),
    )
    earlier = None if before is None else read_rig(before, sizes[0])
    with scratch_folder(folder) as scratch:
        figures = calibration_figures(found, earlier)
        clock.run("write", lambda: _write(scratch, found, config))
        summary = {**figures, **run_figures(clock.seconds)}
        write_json(scratch / "summary.json", summary)
        files = move_files(scratch, folder, [shot.path for shot in shots])
        return PictureOutcome(folder, tuple(files), summary)


def _finders(config: RigConfig, base: Path) -> dict[str, Finder]:
    from shapemorph.io.target_files import read_target

    finders = {}
    for name, target in config.targets.items():
        points = None if target.points is None else read_target(base / target.points)
        finders[name] = make_finder(name, target, points)
    return finders


def list_shots(
    config: RigConfig, base: Path, finders: dict[str, Finder]
) -> tuple[list[View], list[Shot], list[tuple[str, str]]]:
    """List all views and pictures, and what is missing.

    Raises
    ------
    DataError
        If a pattern names no picture, or pictures of two cameras have no name in common.
    """
    views: list[View] = []
    shots: list[Shot] = []
    notes: list[tuple[str, str]] = []
    for entry in config.views:
        found = {name: _pictures(base, entry, name) for name in entry.pictures}
        numbers: dict[str, int] = {}
        if entry.simultaneous:
            notes += _unpaired(found, entry)
        for name, pictures in found.items():
            anchors = tuple(entry.anchors.get(name, ()))
            for key, path in pictures.items():
                own = key if entry.simultaneous else f"{name} {key}"
                if own not in numbers:
                    numbers[own] = len(views)
                    label = f"{entry.target} {own}".strip()
                    views.append(View(label, finders[entry.target].target))
                shots.append(Shot(config.cameras.index(name), numbers[own], path, anchors))
    return views, shots, notes


def _pictures(base: Path, entry: ViewsConfig, camera: str) -> dict[str, Path]:
    try:
        return named_pictures(base, entry.pictures[camera])
    except DataError as error:
        raise DataError(f"camera {camera}, target {entry.target}: {error}") from None


def _unpaired(found: dict[str, dict[str, Path]], entry: ViewsConfig) -> list[tuple[str, str]]:
    """Name pictures that have no partner; raise if none has one."""
    if len(found) < 2:
        return []
    common = set.intersection(*(set(pictures) for pictures in found.values()))
    if not common:
        sets = ", ".join(f"{name}: {_some(pictures)}" for name, pictures in found.items())
        raise DataError(
            f"target {entry.target}: no picture of one camera has the name of one of another "
            f"({sets}): name them alike, or set `simultaneous: false`"
        )
    return [
        (path.name, "no picture of that name from every other camera: used for this one alone")
        for pictures in found.values()
        for key, path in pictures.items()
        if key not in common
    ]


def _some(pictures: dict[str, Path]) -> str:
    names = [path.name for path in pictures.values()]
    return ", ".join(names[:2]) + (", ..." if len(names) > 2 else "")


def _find_all(
    shots: Sequence[Shot], views: Sequence[View], finders: dict[str, Finder], seen: _Seen
) -> None:
    for shot in shots:
        picture = read_grey_image(shot.path)
        height, width = picture.shape
        size = seen.sizes.setdefault(shot.camera, (width, height))
        if size != (width, height):
            raise DataError(
                f"{shot.path.name}: expected {size[0]} x {size[1]} px like the other pictures of "
                f"its camera, got {width} x {height} px: pictures of two cameras mixed up?"
            )
        view = views[shot.view]
        try:
            ids, pixels = find_target(picture.grey, finders[view.target.name], shot.anchors)
        except DataError as error:
            seen.rejected.append((shot.path.name, str(error)))
            continue
        seen.sightings.append(Sighting(shot.camera, shot.view, ids, pixels))


def _require_found(name: str, shots: Sequence[Shot], number: int, seen: _Seen) -> None:
    if not shots:
        raise ConfigError(f"camera {name} has no pictures: name it in `views`")
    if not any(sighting.camera == number for sighting in seen.sightings):
        names = {shot.path.name for shot in shots}
        reasons = [reason for picture, reason in seen.rejected if picture in names]
        raise DataError(
            f"camera {name}: the target was found in none of its {len(shots)} pictures "
            f"({reasons[0]}): check `targets` and that the target is seen whole"
        )


def _write(scratch: Path, found: Calibration, config: RigConfig) -> None:
    from shapemorph.io.config_files import config_text

    views = list(zip(found.views, found.poses, strict=True))
    write_rig(scratch / CALIBRATION_FILE, found.rig, found.uncertainty, views)
    if len(found.rig.cameras) == 2:
        write_exports(scratch, found.rig)
    write_residuals(scratch / "residuals.csv", found)
    (scratch / "rig.yaml").write_text(config_text(config), encoding="utf-8")
    if config.report.figures:
        from shapemorph.view.calibration import write_calibration_figures

        write_calibration_figures(found, scratch / "figures")
