"""The commands: each a few lines that call the pipeline."""

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

import shapemorph
from shapemorph.cli.console import configure_log, show, show_json, watching
from shapemorph.cli.options import Output, Say, Settings
from shapemorph.cli.pictures import Pictures, correlate_pictures, with_figures
from shapemorph.cli.recipes import run_config
from shapemorph.cli.runs import (
    both,
    bring_up_to_date,
    defaults,
    is_config,
    pair_config,
    print_result,
    with_steps,
)

SAY, NO_SETTINGS = Say(), Settings()

app = App(
    name="shapemorph",
    help="Full-field strain between two textured 3D shapes of one object.",
    version=shapemorph.__version__,
    suppress_keyboard_interrupt=False,
    help_format="plaintext",
)


@app.command
def measure(
    reference: Path,
    deformed: Path,
    /,
    *,
    output: Output = None,
    landmarks: Path | None = None,
    settings: Settings = NO_SETTINGS,
    say: Say = SAY,
) -> int:
    """Measure a pair of textured meshes; no configuration is needed.

    Parameters
    ----------
    reference
        Textured mesh before the deformation (OBJ, PLY, GLB, glTF), or a point cloud with grey
        or colour (PLY, CSV, TXT, XYZ).
    deformed
        The same after it; the format may differ.
    landmarks
        CSV name,ref_x,ref_y,ref_z,def_x,def_y,def_z in the frames of the two files.
    """
    inputs = {"reference": reference, "deformed": deformed, "landmarks": landmarks}
    config = pair_config(inputs, settings)
    return bring_up_to_date(config, output or Path(f"{deformed.stem}_run"), say)


@app.command
def run(
    config: Path,
    /,
    *,
    output: Output = None,
    until: str | None = None,
    force: Annotated[list[str] | None, Parameter(negative=())] = None,
    settings: Settings = NO_SETTINGS,
    say: Say = SAY,
) -> int:
    """Bring a run up to date with its configuration; what is current is kept.

    Parameters
    ----------
    config
        YAML file, or the directory of a run.
    until
        Last stage: inputs, flatten, match, morph, correlate, lift, spread, align or strain.
    force
        Stage to run again, with all that depend on it; may be repeated.
    """
    return run_config(config, output, settings, say, until=until, force=force or ())


@app.command
def flatten(
    mesh: Path,
    /,
    *,
    output: Output = None,
    settings: Settings = NO_SETTINGS,
    say: Say = SAY,
) -> int:
    """Flatten one mesh to a calibrated image, or bring this stage of a run up to date.

    Parameters
    ----------
    mesh
        Textured mesh or point cloud (formats as for measure); or the YAML file of a run.
    """
    if is_config(mesh):
        return run_config(mesh, output, settings, say, until="flatten")
    from shapemorph.cli.words import describe_flattening
    from shapemorph.pipeline.one_mesh import flatten_one

    config, folder = defaults(settings), output or Path(f"{mesh.stem}_flat")
    configure_log(say)
    with watching(say) as listener:
        outcome = flatten_one(mesh, folder, config, listener=listener)
    return print_result(outcome.folder, outcome.summary, describe_flattening, say)


@app.command
def morph(
    reference: Path,
    deformed: Path | None = None,
    /,
    *,
    output: Output = None,
    steps: int | None = None,
    settings: Settings = NO_SETTINGS,
    say: Say = SAY,
) -> int:
    """Match two pictures and draw the way between them, or bring this stage of a run up to date.

    Parameters
    ----------
    reference
        Picture before the deformation; or, alone, the YAML file of a run.
    deformed
        Picture after it.
    steps
        Pictures of the sequence, both originals included, even; chosen by itself if empty.
    """
    if is_config(reference) and deformed is None:
        return run_config(reference, output, settings, say, until="morph")
    from shapemorph.cli.words import describe_morph
    from shapemorph.pipeline.planar import morph_images

    second = both(deformed, "morph")
    config, folder = defaults(with_steps(settings, steps)), output or Path(f"{second.stem}_morph")
    configure_log(say)
    with watching(say) as listener:
        outcome = morph_images(reference, second, folder, config, listener=listener)
    return print_result(outcome.folder, outcome.summary, describe_morph, say)


@app.command
def correlate(  # noqa: PLR0913 - one for each option
    reference: Path | None = None,
    deformed: Path | None = None,
    /,
    *,
    output: Output = None,
    sequence: str | None = None,
    mask: Path | None = None,
    figures: bool = True,
    settings: Settings = NO_SETTINGS,
    say: Say = SAY,
) -> int:
    """Correlate two pictures, however far apart, or a sequence; or bring a run up to date.

    Parameters
    ----------
    reference
        Picture before the deformation; or, alone, the YAML file of a run.
    deformed
        Picture after it.
    sequence
        Instead of the two: pictures that follow each other, as a pattern in quotes
        ("frames/*.tif") or a TIFF of many pages. The first is the reference.
    mask
        Picture of the size of the reference, white = measured.
    figures
        Draw the displacement field.
    """
    if reference is not None and is_config(reference) and deformed is None:
        return run_config(reference, output, settings, say, until="correlate")
    pictures = Pictures(reference, deformed, sequence, mask)
    return correlate_pictures(pictures, output, with_figures(settings, figures), say)


@app.command
def assess(
    first: Path,
    second: Path | None = None,
    /,
    *,
    static: Path | None = None,
    settings: Settings = NO_SETTINGS,
    say: Say = SAY,
) -> int:
    """Say how well pictures can be correlated: speckle, gradients, noise, subset to use.

    Parameters
    ----------
    first
        The reference picture.
    second
        A second one: of the same state it gives the noise; with `assess.star.periods` set,
        the deformed picture of a star pattern.
    static
        Star pattern: one more picture of the undeformed state.
    """
    from shapemorph.cli.words import describe_assessment
    from shapemorph.pipeline.assess import assess as assess_pictures

    configure_log(say)
    found = assess_pictures(first, second, static, defaults(settings))
    show_json(found) if say.json else show("\n".join(describe_assessment(found)))
    return 0


def _stage_command(name: str, purpose: str) -> None:
    """Add the command that brings one stage of a run up to date."""

    def stage(
        config: Path,
        /,
        *,
        output: Output = None,
        settings: Settings = NO_SETTINGS,
        say: Say = SAY,
    ) -> int:
        return run_config(config, output, settings, say, until=name)

    stage.__doc__ = f"{purpose}: bring a run up to date as far as this stage."
    app.command(stage, name=name)


_stage_command("match", "Find which points of the two flattened pictures show the same material")
_stage_command("lift", "Carry the correlated points back to space")
_stage_command("spread", "Measure with further laws, flattenings and subsets, and compare")
_stage_command("align", "Find the rigid motion between the two files")
_stage_command("strain", "Measure strain on the tracked surface")
