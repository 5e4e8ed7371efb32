"""Plain pictures at the command line."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from shapemorph.cli.console import configure_log, show, watching
from shapemorph.cli.options import Say, Settings
from shapemorph.cli.runs import both, defaults, print_result
from shapemorph.cli.words import describe_correlation, describe_frames, describe_morph
from shapemorph.core.errors import ConfigError

if TYPE_CHECKING:
    from shapemorph.config import RunConfig


@dataclass(frozen=True, slots=True)
class Pictures:
    """What the command line names: two pictures or a sequence, and a mask."""

    reference: Path | None
    deformed: Path | None
    sequence: str | None
    mask: Path | None


def with_figures(settings: Settings, figures: bool) -> Settings:  # noqa: FBT001 - the option itself
    """Turn `--no-figures` into the setting `report.figures`."""
    return settings if figures else Settings([*settings.set_, "report.figures=false"])


def correlate_pictures(
    pictures: Pictures, output: Path | None, settings: Settings, say: Say
) -> int:
    """Correlate what the command line names and print what was found."""
    from shapemorph.pipeline.planar import correlate_images

    config = defaults(settings)
    if pictures.sequence is not None:
        return _correlate_sequence(pictures, output, config, say)
    if pictures.reference is None:
        raise ConfigError("correlate expects two pictures, --sequence, or one YAML file; got none")
    reference, second = pictures.reference, both(pictures.deformed, "correlate")
    folder = output or Path(f"{second.stem}_correlation")
    configure_log(say)
    with watching(say) as listener:
        outcome = correlate_images(
            reference, second, folder, config, mask=pictures.mask, listener=listener
        )
    return print_result(outcome.folder, outcome.summary, describe_correlation, say)


def _correlate_sequence(
    pictures: Pictures, output: Path | None, config: "RunConfig", say: Say
) -> int:
    from shapemorph.io.frames import list_frames
    from shapemorph.pipeline.frames import correlate_frames

    if pictures.reference is not None:
        raise ConfigError(
            f"--sequence stands instead of two pictures, got {pictures.reference} too: put a "
            "pattern in quotes"
        )
    frames = list_frames(str(pictures.sequence))
    folder = output or Path(f"{frames[-1].path.parent.absolute().name}_correlation")
    configure_log(say)
    with watching(say) as listener:
        outcome = correlate_frames(frames, folder, config, mask=pictures.mask, listener=listener)
    return print_result(outcome.folder, outcome.summary, describe_frames, say)


def bring_pictures_up_to_date(
    config: "RunConfig",
    folder: Path,
    say: Say,
    until: str | None,
    forced: bool,  # noqa: FBT001 - the option itself
) -> int:
    """Correlate, or morph, the pictures of a configuration and print what was found."""
    from shapemorph.pipeline.picture_run import run_pictures

    configure_log(say)
    with watching(say) as listener:
        found = run_pictures(config, folder, until=until, forced=forced, listener=listener)
    if found.is_kept and not say.json:
        show(f"nothing to do: {folder} is up to date")
    return print_result(found.folder, found.summary, _describe(found.stage, found.summary), say)


def _describe(stage: str, summary: dict[str, Any]) -> Any:
    if stage == "morph":
        return describe_morph
    return describe_frames if "frames" in summary else describe_correlation
