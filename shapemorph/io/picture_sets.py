"""Pictures that a pattern names, each with the part of its name that the star stands for."""

import re
from pathlib import Path

from shapemorph.core.errors import DataError

_NUMBERS = re.compile(r"(\d+)")


def named_pictures(base: Path, pattern: str) -> dict[str, Path]:
    """Find the files of a pattern; the key is what the star stands for, empty without a star.

    Parameters
    ----------
    base : Path
        Folder that the pattern is relative to.
    pattern : str
        Path with at most one star, in the name of the file or of one folder.

    Raises
    ------
    DataError
        If nothing is there, or there are several stars.
    """
    if pattern.count("*") > 1:
        raise DataError(f"pictures {pattern}: expected one star, got {pattern.count('*')}")
    if "*" not in pattern:
        path = base / Path(pattern).expanduser()
        if not path.is_file():
            raise DataError(f"pictures {pattern}: there is no such file in {base}")
        return {"": path}
    place = Path(pattern).expanduser()
    root = Path(place.anchor) if place.is_absolute() else base
    relative = str(place.relative_to(place.anchor)) if place.is_absolute() else str(place)
    found = sorted((path for path in root.glob(relative) if path.is_file()), key=_by_number)
    if not found:
        folder = next(path for path in (root / relative).parents if "*" not in path.name)
        raise DataError(f"pictures {pattern}: no file in {folder} matches")
    head, _, tail = relative.partition("*")
    names = {}
    for path in found:
        text = str(path.relative_to(root))
        names[text[len(head) : len(text) - len(tail)]] = path
    return names


def _by_number(path: Path) -> list[tuple[int, str]]:
    """Order names as people do: 2 before 10."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in _NUMBERS.split(str(path))]
