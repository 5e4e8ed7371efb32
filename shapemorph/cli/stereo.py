"""Stereo experiments at the command line."""

from pathlib import Path
from typing import TYPE_CHECKING, get_args

from shapemorph.cli.console import watching
from shapemorph.cli.options import Say, Settings
from shapemorph.cli.runs import is_config
from shapemorph.core.errors import ConfigError

if TYPE_CHECKING:
    from shapemorph.config import TwinConfig


def write_stereo_twin(
    kind: str, output: Path | None, settings: Settings, say: Say
) -> tuple[list[Path], Path]:
    """Write a synthetic stereo experiment; return its files and folder."""
    from shapemorph.pipeline.twin import write_twin_case

    config, folder = read_twin(kind, settings), output or Path(f"{Path(kind).stem}_twin")
    with watching(say) as listener:
        return write_twin_case(config, folder, listener=listener), folder


def read_twin(kind: str, settings: Settings) -> "TwinConfig":
    """Read the YAML file of a stereo experiment, or make a default one of a kind.

    Raises
    ------
    ConfigError
        If there is no such kind or file, or the file is wrong.
    """
    from shapemorph.config import TwinConfig
    from shapemorph.io.config_files import check_config, read_config
    from shapemorph.pipeline.twin import TwinFile

    if is_config(Path(kind)):
        return read_config(Path(kind), TwinFile, settings.set_).twin
    kinds = get_args(TwinConfig.model_fields["kind"].annotation)
    if kind not in kinds:
        raise ConfigError(
            f"expected a stereo experiment ({', '.join(kinds)}) or a YAML file, got {kind!r}"
        )
    return check_config({"twin": {"kind": kind}}, TwinFile, settings.set_).twin
