"""Pictures that a configuration file names: bring their results up to date."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from shapemorph.config import RunConfig
from shapemorph.core.errors import ConfigError
from shapemorph.io.config_files import config_text
from shapemorph.io.frames import list_frames
from shapemorph.io.safe_files import whole_file
from shapemorph.pipeline.fingerprints import code_fingerprint, files_fingerprint, fingerprint
from shapemorph.pipeline.law_inputs import law_files
from shapemorph.pipeline.planar import PictureOutcome, correlate_images, morph_images
from shapemorph.pipeline.run import Listener

STAGES = ("morph", "correlate")
RECORD = "pictures.json"


@dataclass(frozen=True, slots=True)
class PictureRun:
    """What bringing the results of pictures up to date did.

    Attributes
    ----------
    stage : str
        "morph" or "correlate".
    folder : Path
    summary : dict
    is_kept : bool
        Whether everything was up to date already.
    """

    stage: str
    folder: Path
    summary: dict[str, Any]
    is_kept: bool


def run_pictures(
    config: RunConfig, folder: Path, *, until: str | None, forced: bool, listener: Listener
) -> PictureRun:
    """Correlate, or morph, the pictures of a configuration unless that is done already.

    Parameters
    ----------
    config : RunConfig
        With absolute paths; `inputs` names pictures.
    folder : Path
    until : str or None
        Stage; None: the last.
    forced : bool
        Do it even if it is done already.

    Raises
    ------
    ConfigError
        If pictures have no such stage, or one picture is missing.
    """
    stage = until or STAGES[-1]
    if stage not in STAGES:
        raise ConfigError(
            f"stage {stage} needs two textured meshes, got pictures: pictures have the stages "
            f"{' and '.join(STAGES)}"
        )
    wanted = fingerprint(
        stage,
        code_fingerprint(including_view=True),
        config.model_dump(mode="json", exclude={"inputs": {"reference", "deformed", "sequence"}}),
        files_fingerprint(_files(config)),
    )
    if not forced and (summary := _finished(folder, wanted)) is not None:
        return PictureRun(stage, folder, summary, is_kept=True)
    (folder / RECORD).unlink(missing_ok=True)
    outcome = _make(stage, config, folder, listener)
    with whole_file(folder / "run.yaml") as partial:
        partial.write_text(config_text(config), encoding="utf-8")
    with whole_file(folder / RECORD) as partial:
        partial.write_text(json.dumps({"fingerprint": wanted}) + "\n", encoding="utf-8")
    return PictureRun(stage, folder, outcome.summary, is_kept=False)


def _make(stage: str, config: RunConfig, folder: Path, listener: Listener) -> PictureOutcome:
    inputs = config.inputs
    if inputs.sequence is not None:
        from shapemorph.pipeline.frames import correlate_frames

        if stage == "morph":
            raise ConfigError("morph takes two pictures, got inputs.sequence: name two of them")
        frames = list_frames(str(inputs.sequence))
        return correlate_frames(frames, folder, config, mask=None, listener=listener)
    reference, deformed = _pair(config)
    if stage == "morph":
        return morph_images(reference, deformed, folder, config, listener=listener)
    return correlate_images(reference, deformed, folder, config, mask=None, listener=listener)


def _pair(config: RunConfig) -> tuple[Path, Path]:
    reference, deformed = config.inputs.reference, config.inputs.deformed
    if reference is None or deformed is None:
        raise ConfigError("expected inputs.reference and inputs.deformed, or inputs.sequence")
    return reference, deformed


def _files(config: RunConfig) -> list[Path]:
    """Every file that is read."""
    inputs = config.inputs
    if inputs.sequence is not None:
        paths = [frame.path for frame in list_frames(str(inputs.sequence))]
    else:
        paths = [*_pair(config)]
    if inputs.region is not None and inputs.region.mask is not None:
        paths.append(inputs.region.mask)
    return [*paths, *law_files(config.morph, (config.morph.law,))]


def _finished(folder: Path, wanted: str) -> dict[str, Any] | None:
    """Summary of what was made with the same fingerprint, if it is all there."""
    try:
        record = json.loads((folder / RECORD).read_text(encoding="utf-8"))
        summary: dict[str, Any] = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return summary if record == {"fingerprint": wanted} else None
