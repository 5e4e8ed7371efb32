"""Shape-morphing of what two cameras saw: both shapes are reconstructed, then measured."""

import json
from pathlib import Path

from shapemorph.config import RunConfig
from shapemorph.core.laws import LawInputs
from shapemorph.core.mesh import TexturedMesh
from shapemorph.io.mesh_writers import write_mesh
from shapemorph.io.safe_files import check_writable, move_files, scratch_folder
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.picture_match import follow_pictures
from shapemorph.pipeline.planar import PictureOutcome
from shapemorph.pipeline.run import Listener
from shapemorph.pipeline.stereo_inputs import StereoSequence, stereo_sequence


def measure_shapes(config: RunConfig, folder: Path, *, listener: Listener) -> PictureOutcome:
    """Reconstruct the first and the last state and measure one shape against the other.

    Parameters
    ----------
    config : RunConfig
        `inputs.left`, `inputs.right`, `inputs.rig`, and all sections of a measurement. Both
        states are in the frame of the rig, so that nothing is aligned.
    folder : Path
        Gets the run; the textured meshes go beside it, into `<folder>_shapes`.

    Raises
    ------
    ConfigError, DataError, StageError
        If a state cannot be reconstructed, or the shapes cannot be measured.
    """
    from shapemorph.pipeline.measure import check_is_run, measure

    check_is_run(folder)
    check_writable(folder)
    shapes = folder.with_name(f"{folder.name}_shapes")
    check_writable(shapes)
    clock = Clock(listener)
    sequence = stereo_sequence(config)
    ends = (("reference", 0), ("deformed", sequence.states - 1))
    with scratch_folder(shapes) as scratch:
        for name, state in ends:
            mesh = _reconstructed(sequence, state, config, clock)
            write_mesh(scratch / f"{name}.obj", mesh)
        move_files(scratch, shapes)
    outcome = measure(of_meshes(config, shapes), folder, listener=listener)
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    files = tuple(path for path in folder.rglob("*") if path.is_file())
    return PictureOutcome(outcome.folder, files, summary)


def of_meshes(config: RunConfig, shapes: Path) -> RunConfig:
    """Turn the configuration of a stereo sequence into that of its two reconstructed shapes."""
    from shapemorph.config import InputsConfig

    inputs = InputsConfig(
        reference=(shapes / "reference.obj").absolute(),
        deformed=(shapes / "deformed.obj").absolute(),
    )
    align = config.align.model_copy(update={"method": "none"})
    # flanks that both cameras see at a slant have a blurred texture, on which subsets err by
    # more than their random error
    correlate = config.correlate.with_certainty()
    return config.model_copy(update={"inputs": inputs, "align": align, "correlate": correlate})


def _reconstructed(
    sequence: StereoSequence, state: int, config: RunConfig, clock: Clock
) -> TexturedMesh:
    """Match both views of a state, place what they see in space and lay the pattern on it."""
    from shapemorph.methods.cameras.grid_surface import mesh_of
    from shapemorph.stages.reconstruct import reconstruct

    left = sequence.first() if state == 0 else sequence.picture("left", state)
    right = sequence.picture("right", state)
    grid = follow_pictures(left, right, config, LawInputs(), clock).grid
    found = clock.run("reconstruct", lambda: reconstruct(sequence.pair(), grid, config.reconstruct))
    return clock.run("texture", lambda: mesh_of(found, left, right))
