"""Files that are either whole or not there."""

import contextlib
import json
import math
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from shapemorph.core.errors import ConfigError


def check_writable(folder: Path) -> None:
    """Raise before any work if `folder` cannot be made or written; leaves nothing behind.

    Raises
    ------
    ConfigError
        Naming the place and the reason.
    """
    place = folder.absolute()
    try:
        while not place.exists():
            place = place.parent
        if not place.is_dir():
            raise ConfigError(
                f"output {folder}: {place} is a file, expected a directory: choose another "
                "place with -o"
            )
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError as error:
        raise ConfigError(
            f"output {folder}: cannot write in {place} ({error.strerror}): choose another place "
            "with -o"
        ) from error


@contextlib.contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a temporary path beside `path` that takes its place when the block succeeds."""
    partial = path.with_name(f".partial-{path.name}")
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


@contextlib.contextmanager
def whole_folder(folder: Path) -> Iterator[Path]:
    """Give a temporary folder beside `folder` that takes its place when the block succeeds.

    At every moment `folder` is the old one, absent, or the new one: never a mixture.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    partial = folder.with_name(f".partial-{folder.name}")
    old = folder.with_name(f".old-{folder.name}")
    remove_folder(partial)
    remove_folder(old)
    partial.mkdir()
    try:
        yield partial
        if folder.exists():
            folder.rename(old)
        partial.rename(folder)
    finally:
        remove_folder(partial)
        remove_folder(old)


@contextlib.contextmanager
def scratch_folder(folder: Path) -> Iterator[Path]:
    """Give an empty folder in `folder` that is gone after the block.

    A `folder` that was made for it, and to which nothing was moved, goes with it.
    """
    scratch = folder / ".partial-files"
    is_new = not folder.exists()
    remove_folder(scratch)
    scratch.mkdir(parents=True)
    try:
        yield scratch
    finally:
        remove_folder(scratch)
        if is_new and not any(folder.iterdir()):
            folder.rmdir()


def move_files(source: Path, target: Path, keep: Sequence[Path] = ()) -> list[Path]:
    """Move every file below `source` to the same place below `target`; return where they are.

    Both lie on one file system; each file is replaced whole. None is moved if one would
    take the place of a file of `keep`.

    Raises
    ------
    ConfigError
        If it would.
    """
    files = {path: target / path.relative_to(source) for path in source.rglob("*")}
    files = {path: place for path, place in sorted(files.items()) if path.is_file()}
    kept = {path.resolve() for path in keep}
    lost = [place for place in files.values() if place.resolve() in kept]
    if lost:
        raise ConfigError(
            f"output {target}: {lost[0].name} would be written over the one that was read: choose "
            "another directory with -o"
        )
    moved = []
    for path, place in files.items():
        place.parent.mkdir(parents=True, exist_ok=True)
        os.replace(path, place)  # noqa: PTH105 - the one call that is named in the promise
        moved.append(place)
    return moved


def remove_folder(folder: Path) -> None:
    """Remove a folder and everything in it, if it is there."""
    if folder.exists():
        shutil.rmtree(folder)


def write_json(path: Path, content: Any) -> None:
    """Write JSON, readable by people; NaN and infinities become null."""
    text = json.dumps(without_nan(content), indent=2, ensure_ascii=False, allow_nan=False)
    with whole_file(path) as partial:
        partial.write_text(text + "\n", encoding="utf-8")


def without_nan(content: Any) -> Any:
    """Replace NaN and infinities, which JSON does not know, by None."""
    if isinstance(content, dict):
        return {str(key): without_nan(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [without_nan(value) for value in content]
    if isinstance(content, float) and not math.isfinite(content):
        return None
    return content
