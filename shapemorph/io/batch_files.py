"""The cases of a batch: from a list, a CSV table, or folders on the disk."""

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from shapemorph.config import BatchConfig, FoldersConfig, RunConfig
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.io.config_files import Document, absolute_paths, laid_over, nested, read_yaml

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")
_SHORT = {key: ("inputs", key) for key in ("reference", "deformed", "landmarks")}


@dataclass(frozen=True, slots=True)
class Case:
    """One specimen of a batch.

    Attributes
    ----------
    name : str
        At once the name of its folder.
    document : dict
        Sections of its run with absolute paths, not checked yet.
    """

    name: str
    document: Document


def read_cases(config: BatchConfig, path: Path) -> tuple[Case, ...]:
    """Lay every case over the base configuration.

    Parameters
    ----------
    config : BatchConfig
        With absolute paths.
    path : Path
        The batch file; paths in it are relative to it, those in a table to the table.

    Raises
    ------
    ConfigError
        If there is no case, or two have one name, or a name cannot be that of a folder.
    DataError
        If the table cannot be read.
    """
    home = path.absolute().parent
    base = _base(config, home)
    found = [
        Case(_name_of(keys, number), laid_over(base, _document(keys, place)))
        for number, (keys, place) in enumerate(_raw_cases(config, home), start=1)
    ]
    _refuse_doubles([case.name for case in found], path)
    return tuple(found)


def _base(config: BatchConfig, home: Path) -> Document:
    if isinstance(config.base, Path):
        document, _ = read_yaml(config.base)
        return absolute_paths(document, RunConfig, config.base.parent)
    return absolute_paths(unfolded(config.base), RunConfig, home)


def _raw_cases(config: BatchConfig, home: Path) -> Iterator[tuple[Document, Path]]:
    """Yield keys of each case and the folder that its paths start from."""
    if config.cases is not None:
        yield from ((case, home) for case in config.cases)
    elif config.table is not None:
        yield from ((row, config.table.parent) for row in _rows(config.table))
    elif config.folders is not None:
        yield from ((case, home) for case in _folder_cases(config.folders, home))


def _rows(path: Path) -> Iterator[Document]:
    """Read a CSV table: values are YAML, empty cells say nothing."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            rows = list(csv.DictReader(stream))
    except (OSError, ValueError, csv.Error) as error:
        raise DataError(f"{path}: expected a CSV table of cases, got {error}") from error
    for number, row in enumerate(rows, start=2):
        cells = {key: text.strip() for key, text in row.items() if key and text and text.strip()}
        if None in row:
            raise DataError(f"{path} line {number}: more cells than the header has names")
        yield {key: _cell(key, text, path, number) for key, text in cells.items()}


def _cell(key: str, text: str, path: Path, line: int) -> Any:
    if key in ("name", *_SHORT):
        return text
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise DataError(f"{path} line {line}: {key} is not YAML: {text!r}") from error


def _folder_cases(folders: FoldersConfig, home: Path) -> Iterator[Document]:
    for folder in sorted(_matching(home, folders.pattern), key=lambda path: path.name):
        if folder.is_dir():
            sides = {"reference": folders.reference, "deformed": folders.deformed}
            yield {"name": folder.name} | {
                side: str(_one_file(folder, pattern)) for side, pattern in sides.items()
            }


def _matching(home: Path, pattern: str) -> list[Path]:
    """Paths that match a pattern, which may be absolute."""
    anchor = Path(pattern).anchor
    start = Path(anchor) if anchor else home
    return list(start.glob(pattern.removeprefix(anchor)))


def _one_file(folder: Path, pattern: str) -> Path:
    """Find the mesh; where it is missing or not the only one, the run of the case will say so."""
    from shapemorph.io.meshes import READERS

    files = sorted(path for path in folder.glob(pattern) if path.suffix.lower() in READERS)
    return files[0] if len(files) == 1 else folder / pattern


def _document(keys: Document, home: Path) -> Document:
    settings = {key: value for key, value in keys.items() if key != "name"}
    return absolute_paths(unfolded(settings), RunConfig, home)


def unfolded(keys: Mapping[str, Any]) -> Document:
    """Turn dotted keys, and short ones of the inputs, into sections."""
    document: Document = {}
    for key, value in keys.items():
        parts = _SHORT.get(key, tuple(str(key).split(".")))
        document = laid_over(document, nested(parts, value))
    return document


def _name_of(keys: Document, number: int) -> str:
    name = str(keys.get("name", ""))
    if not _NAME.fullmatch(name):
        raise ConfigError(
            f"case {number}: expected a name of letters, digits, '.', '_' and '-' (it names the "
            f"folder of the case), got {keys.get('name')!r}"
        )
    return name


def _refuse_doubles(names: Sequence[str], path: Path) -> None:
    if not names:
        raise ConfigError(f"{path}: expected at least one case, found none")
    doubles = sorted({name for name in names if names.count(name) > 1})
    if doubles:
        raise ConfigError(f"{path}: expected one case of each name, got {', '.join(doubles)} twice")
