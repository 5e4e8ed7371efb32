"""The commands for cameras: calibration and reconstruction."""

from pathlib import Path

from shapemorph.cli.app import NO_SETTINGS, SAY
from shapemorph.cli.console import configure_log, watching
from shapemorph.cli.lab import app
from shapemorph.cli.options import Output, Say, Settings
from shapemorph.cli.runs import print_result
from shapemorph.core.errors import ConfigError

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


@app.command
def reconstruct(  # noqa: PLR0913 - one for each option
    calibration: Path,
    left: Path | None = None,
    right: Path | None = None,
    /,
    *,
    output: Output = None,
    mask: Path | None = None,
    settings: Settings = NO_SETTINGS,
    say: Say = SAY,
) -> int:
    """Reconstruct what calibrated cameras see: a textured mesh, ready for measure.

    Parameters
    ----------
    calibration
        calibration.json, or a file of OpenCV (.yml), VIC-3D (.xml), MatchID (.caldat) or
        OpenCorr (.csv). Or, alone, a YAML file that names many views of a part that turned.
    left
        Picture of the first camera of the calibration.
    right
        Picture of the second one, of the same moment.
    mask
        Picture of the size of the left one, white = measured.
    """
    from shapemorph.cli.camera_words import describe_reconstruction
    from shapemorph.cli.runs import defaults, is_config
    from shapemorph.pipeline.reconstruct import reconstruct_pictures

    if left is None and is_config(calibration):
        return _reconstruct_turn(calibration, output, settings, say)
    if left is None or right is None:
        raise ConfigError("reconstruct expects a calibration and two pictures, or one YAML file")
    config, folder = defaults(settings), output or Path(f"{left.stem}_shape")
    configure_log(say)
    with watching(say) as listener:
        found = reconstruct_pictures(
            calibration, left, right, folder, config, mask=mask, listener=listener
        )
    return print_result(found.folder, found.summary, describe_reconstruction, say)


def _reconstruct_turn(path: Path, output: Path | None, settings: Settings, say: Say) -> int:
    """Reconstruct a part from many views."""
    from shapemorph.cli.camera_words import describe_turn
    from shapemorph.config import TurnConfig
    from shapemorph.io.config_files import read_config
    from shapemorph.pipeline.turn import reconstruct_turn

    config = read_config(path, TurnConfig, settings.set_)
    configure_log(say)
    with watching(say) as listener:
        found = reconstruct_turn(
            config,
            path.absolute().parent,
            output or Path(f"{path.stem}_shape"),
            listener=listener,
        )
    return print_result(found.folder, found.summary, describe_turn, say)
