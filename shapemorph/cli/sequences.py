"""The commands for what two cameras saw over time."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from shapemorph.cli.app import NO_SETTINGS, SAY
from shapemorph.cli.cameras import app
from shapemorph.cli.console import configure_log, watching
from shapemorph.cli.options import Output, Say, Settings
from shapemorph.cli.runs import print_result
from shapemorph.core.errors import ConfigError

__all__ = ["app"]  # with all commands, those of this module included


@app.command
def track(  # noqa: PLR0913 - one for each option
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
    """Follow points through the pictures of two cameras, from the first state to the last.

    Parameters
    ----------
    calibration
        Calibrated cameras, left and right (formats as for reconstruct); or, alone, a YAML file
        whose section inputs names left, right and rig.
    left
        Pictures of the left camera, one for each state, as a pattern in quotes ("left_*.png").
    right
        Those of the right camera.
    mask
        Picture of the size of the first left one, white = measured.
    """
    from shapemorph.cli.recipes import run_config
    from shapemorph.cli.runs import is_config, pair_config
    from shapemorph.cli.stereo import track_pictures

    if left is None and right is None and is_config(calibration):
        return run_config(calibration, output, settings, say)
    if left is None or right is None:
        raise ConfigError("track expects a calibration and the pictures of both cameras, or YAML")
    given: dict[str, Path | None] = {"rig": calibration, "left": left, "right": right}
    if mask is not None:
        settings = Settings([*settings.set_, f"inputs.region.mask={mask.absolute()}"])
    config = pair_config(given, settings)
    return track_pictures(config, output or Path(f"{left.parent.absolute().name}_track"), say)


@app.command
def reproduce(
    case: str = "membrane",
    /,
    *,
    output: Output = None,
    quick: Annotated[bool, Parameter(negative=())] = False,
    settings: Settings = NO_SETTINGS,
    say: Say = SAY,
) -> int:
    """Reproduce the paper on a synthetic twin: every method against the truth, on one page.

    Parameters
    ----------
    case
        membrane, bulge, or a YAML file with a section `reproduce` or `bulge`.
    quick
        Small pictures and few states: minutes instead of half an hour.
    """
    from shapemorph.cli.stereo import describe_bulge, describe_reproduction, read_reproduction
    from shapemorph.config import BulgeConfig
    from shapemorph.pipeline.reproduce import reproduce_membrane
    from shapemorph.pipeline.reproduce_bulge import reproduce_bulge

    config = read_reproduction(case, settings, quick=quick)
    folder = output or Path(f"{Path(case).stem}_reproduction")
    configure_log(say)
    with watching(say) as listener:
        if isinstance(config, BulgeConfig):
            summary = reproduce_bulge(config, folder, listener=listener)
            return print_result(folder, summary, describe_bulge, say)
        summary = reproduce_membrane(config, folder, listener=listener)
    return print_result(folder, summary, describe_reproduction, say)
