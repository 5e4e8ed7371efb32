"""Runs that a configuration file describes: which pipeline it is for."""

from collections.abc import Sequence
from pathlib import Path

from shapemorph.cli.options import Say, Settings
from shapemorph.cli.pictures import bring_pictures_up_to_date
from shapemorph.cli.runs import bring_up_to_date, read_run_config
from shapemorph.cli.stereo import track_pictures


def run_config(
    path: Path,
    output: Path | None,
    settings: Settings,
    say: Say,
    *,
    until: str | None = None,
    force: Sequence[str] = (),
) -> int:
    """Bring the run of a configuration file up to date."""
    from shapemorph.pipeline.pictures import measures_pictures

    config = read_run_config(path, settings)
    if config.inputs.left is not None:
        return track_pictures(config, output or _home(path), say)
    if measures_pictures(config):
        return bring_pictures_up_to_date(config, output or _home(path), say, until, bool(force))
    return bring_up_to_date(config, output or _home(path), say, until=until, force=force)


def _home(path: Path) -> Path:
    """Folder of a run: that of its own run.yaml, else one named after the configuration."""
    if path.is_dir():
        return path
    records = ("outputs.json", "pictures.json")
    if path.name == "run.yaml" and any((path.parent / name).is_file() for name in records):
        return path.parent
    return Path(f"{path.stem}_run")
