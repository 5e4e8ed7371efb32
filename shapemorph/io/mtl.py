"""Wavefront material files: which picture lies on which material."""

import math
from dataclasses import dataclass
from pathlib import Path

from shapemorph.core.errors import DataError
from shapemorph.io.images import read_bytes

# Options of map_Kd and how many values follow each; -o, -s and -t take one to three.
_OPTION_VALUES = {
    "-blendu": 1,
    "-blendv": 1,
    "-boost": 1,
    "-bm": 1,
    "-cc": 1,
    "-clamp": 1,
    "-imfchan": 1,
    "-mm": 2,
    "-texres": 1,
    "-type": 1,
}
_VECTOR_OPTIONS = ("-o", "-s", "-t")


@dataclass(frozen=True, slots=True)
class Material:
    """A named material.

    Attributes
    ----------
    name : str
    folder : Path
        Of the material file.
    picture : str or None
        As the file names it; None where the material has a plain colour only.
    scale, offset : (float, float)
        The picture is looked up at ``uv * scale + offset``.
    clamp : bool
        Whether the picture ends at its border instead of repeating.
    """

    name: str
    folder: Path
    picture: str | None = None
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    clamp: bool = False


def read_materials(path: Path) -> list[Material]:
    """Read all materials of an MTL file."""
    data = read_bytes(path, what="material")
    if b"\0" in data:
        raise DataError(f"{path.name}: expected a text file of materials, got binary data")
    materials: list[Material] = []
    for line in decode_text(data).splitlines():
        words = line.strip().split(None, 1)
        if not words or words[0].startswith("#"):
            continue
        key, rest = words[0].lower(), words[1].strip() if len(words) > 1 else ""
        if key == "newmtl":
            materials.append(Material(rest, path.parent))
        elif key == "map_kd" and rest and materials:
            materials[-1] = _with_picture(materials[-1], rest)
    return materials


def decode_text(data: bytes) -> str:
    """Decode names: UTF-8, else Latin-1."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _with_picture(material: Material, statement: str) -> Material:
    """Read the options and the file name of a map_Kd statement."""
    vectors: dict[str, tuple[float, float]] = {}
    clamp = material.clamp
    rest = statement
    while rest.startswith("-"):
        option, _, after = rest.partition(" ")
        key = option.lower()
        if key in _VECTOR_OPTIONS:
            vectors[key], rest = _leading_numbers(after, 1.0 if key == "-s" else 0.0)
        elif key in _OPTION_VALUES:
            values, rest = _split(after, _OPTION_VALUES[key])
            clamp = values[0].lower() == "on" if key == "-clamp" and values else clamp
        else:
            break  # a name may begin with a dash
    scale, offset = vectors.get("-s", (1.0, 1.0)), vectors.get("-o", (0.0, 0.0))
    return Material(material.name, material.folder, _unquoted(rest), scale, offset, clamp)


def _leading_numbers(text: str, missing: float) -> tuple[tuple[float, float], str]:
    """Take one to three leading numbers; return the first two and what follows."""
    values: list[float] = []
    rest = text.lstrip()
    while len(values) < 3:
        word, _, after = rest.partition(" ")
        try:
            number = float(word)
        except ValueError:
            break
        if not math.isfinite(number):
            break
        values.append(number)
        rest = after.lstrip()
    padded = [*values, missing, missing]
    return (padded[0], padded[1]), rest


def _split(text: str, count: int) -> tuple[list[str], str]:
    """Take `count` words; return them and what follows."""
    words = text.split(None, count)
    return words[:count], words[count] if len(words) > count else ""


def _unquoted(name: str) -> str:
    return name.strip().strip('"').strip()
