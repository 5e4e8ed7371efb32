"""The commands for cameras: calibration and reconstruction."""

from pathlib import Path

from shapemorph.cli.app import NO_SETTINGS, SAY
from shapemorph.cli.console import configure_log, watching
from shapemorph.cli.lab import app
from shapemorph.cli.options import Output, Say, Settings
from shapemorph.cli.runs import print_result

__all__ = ["app"]  # with all commands, those of this module included


@app.command
def calibrate(
    rig: Path,
    /,
    *,
    output: Output = None,
    settings: Settings = NO_SETTINGS,
    say: Say = SAY,
) -> int:
    """Calibrate one, two or many cameras from pictures of targets.

    Parameters
    ----------
    rig
        YAML file with the sections cameras, targets, views and calibrate.
    """
    from shapemorph.cli.camera_words import describe_calibration
    from shapemorph.config import RigConfig
    from shapemorph.io.config_files import read_config
    from shapemorph.pipeline.calibrate import calibrate_cameras

    config = read_config(rig, RigConfig, settings.set_)
    folder = output or Path(f"{rig.stem}_calibration")
    configure_log(say)
    with watching(say) as listener:
        found = calibrate_cameras(config, rig.absolute().parent, folder, listener=listener)
    return print_result(found.folder, found.summary, describe_calibration, say)
