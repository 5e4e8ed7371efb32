"""What morph laws read: which files, their fingerprint, their content."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from shapemorph.config import Law, MorphConfig
from shapemorph.core.errors import ConfigError
from shapemorph.core.landmarks import Landmarks
from shapemorph.core.laws import Dots, LawInputs
from shapemorph.pipeline.fingerprints import file_fingerprint, fingerprint


def law_files(config: MorphConfig, laws: Sequence[Law]) -> list[Path]:
    """Files that some laws read, beside those of the section `inputs`."""
    wanted = [config.dots] if "landmarks" in laws else []
    if "fe" in laws:
        wanted += [config.fe, config.fe_deformed]
    return [path for path in wanted if path is not None]


def law_fingerprint(
    config: MorphConfig, laws: Sequence[Law], unit: str, landmarks: Callable[[], str]
) -> str:
    """Digest of what some laws read, and of how.

    Parameters
    ----------
    unit : str
        Of finite element results that have none of their own.
    landmarks : callable
        Gives the digest of the landmarks of the run.
    """
    read: list[Any] = [file_fingerprint(path) for path in law_files(config, laws)]
    if "fe" in laws:
        read += [config.fe_units or unit, config.fe.suffix if config.fe else None]
    if _asks_for_landmarks(config, laws):
        read.append(landmarks())
    return fingerprint(read)


def read_law_inputs(
    config: MorphConfig,
    laws: Sequence[Law],
    mm_per_unit: Callable[[str | None], float],
    landmarks: Callable[[], Landmarks | None],
) -> LawInputs:
    """Read what some laws need.

    Parameters
    ----------
    mm_per_unit : callable
        Scale of a unit; None is that of the reference file.
    landmarks : callable
        Gives the landmarks of the run.

    Raises
    ------
    ConfigError, DataError
        If something is not given, or not what it should be.
    """
    from shapemorph.io.fe_files import read_dots, read_finite_elements

    dots, elements, marks = None, None, None
    if "landmarks" in laws and config.dots is not None:
        dots = Dots(*read_dots(config.dots))
    if _asks_for_landmarks(config, laws):
        marks = landmarks()
        if marks is None:
            raise ConfigError("law landmarks needs marks: give morph.dots or inputs.landmarks")
    if "fe" in laws and config.fe is not None:
        elements = read_finite_elements(
            config.fe,
            scale=mm_per_unit(config.fe_units),
            model=config.fe_model,
            moved=config.fe_deformed,
            displacement=config.fe_displacement,
        )
    return LawInputs(marks, dots, elements)


def _asks_for_landmarks(config: MorphConfig, laws: Sequence[Law]) -> bool:
    return "landmarks" in laws and config.dots is None
