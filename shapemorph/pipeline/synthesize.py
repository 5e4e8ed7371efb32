"""Write a synthetic pair with its truth."""

from pathlib import Path

from pydantic import Field

from shapemorph.config import Section, SynthesizeConfig
from shapemorph.core.errors import ConfigError
from shapemorph.io.safe_files import check_writable


class SynthesizeFile(Section):
    """The YAML file of a synthetic case."""

    synthesize: SynthesizeConfig = Field(SynthesizeConfig(), description="the case")


def write_case(config: SynthesizeConfig, folder: Path) -> list[Path]:
    """Make the pair and write both meshes and ``truth.npz``.

    Raises
    ------
    ConfigError
        If the folder cannot be written, holds meshes of another origin, or the case is
        impossible.
    """
    from shapemorph.io.truth_files import TRUTH, write_pair
    from shapemorph.stages.synthesize import synthesize

    check_writable(folder)
    meshes = sorted((*folder.glob("reference.*"), *folder.glob("deformed.*")))
    if meshes and not (folder / TRUTH).is_file():
        raise ConfigError(
            f"output {folder} holds {meshes[0].name} and is no synthetic case: choose another "
            "directory with -o"
        )
    return write_pair(folder, synthesize(config), file_format=config.format)
