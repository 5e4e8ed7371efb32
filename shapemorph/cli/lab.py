"""The commands for a laboratory: noise floor, many specimens, files for other programs."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from shapemorph.cli.app import NO_SETTINGS, SAY
from shapemorph.cli.around import app
from shapemorph.cli.console import configure_log, show, show_json, watching
from shapemorph.cli.options import Output, Say, Settings
from shapemorph.cli.runs import pair_config, print_result

__all__ = ["app"]  # with all commands, those of this module included


@app.command
def noise(
    first: Path,
    second: Path,
    /,
    *,
    output: Output = None,
    same_frame: Annotated[bool, Parameter(negative=())] = False,
    settings: Settings = NO_SETTINGS,
    say: Say = SAY,
) -> int:
    """Measure two scans of one state: noise floor and bias of displacement and strain.

    Parameters
    ----------
    first, second
        Textured meshes of one state, scanned twice; moved rigidly between or not.
    same_frame
        The object did not move and both files are in one frame: no rigid motion is taken out.
    """
    from shapemorph.cli.words import describe_noise
    from shapemorph.pipeline.noise import measure_noise

    config = pair_config({"reference": first, "deformed": second}, settings)
    folder = output or Path(f"{second.stem}_noise")
    configure_log(say)
    with watching(say) as listener:
        found = measure_noise(config, folder, same_frame=same_frame, listener=listener)
    return print_result(folder, found, describe_noise, say)


@app.command
def batch(
    config: Path,
    /,
    *,
    output: Output = None,
    scheduler: str | None = None,
    settings: Settings = NO_SETTINGS,
    say: Say = SAY,
) -> int:
    """Measure many pairs, on all cores or on a Dask cluster; what is current is kept.

    Parameters
    ----------
    config
        YAML file of a batch: a base configuration and a list, a table or folders of cases.
    scheduler
        Address of a Dask scheduler (tcp://host:8786) whose workers see the same files.
    """
    from shapemorph.cli.batches import print_batch, read_batch, watching_batch
    from shapemorph.pipeline.batch import run_batch

    plan, cases, over = read_batch(config, settings)
    folder = output or Path(f"{config.stem}_batch")
    configure_log(say)
    with watching_batch(say) as listener:
        outcome = run_batch(
            plan, cases, folder, settings=over, scheduler=scheduler, listener=listener
        )
    return print_batch(outcome, say)


@app.command
def export(
    run_folder: Path,
    /,
    *,
    format_: Annotated[str, Parameter(name="--format")] = "npz",
    say: Say = SAY,
) -> int:
    """Write the measurement of a finished run as NPZ or MAT, with the arrays of the VTP.

    Parameters
    ----------
    run_folder
        Directory of the run; measurement.npz or measurement.mat is written into it.
    format_
        npz (NumPy) or mat (MATLAB, Octave).
    """
    from shapemorph.pipeline.export import export as export_run

    path = export_run(run_folder, format_)
    show_json({"file": str(path)}) if say.json else show(str(path))
    return 0
