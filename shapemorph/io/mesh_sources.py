"""Which files a mesh consists of, found without loading it."""

import contextlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

from shapemorph.core.errors import DataError
from shapemorph.io.mtl import decode_text, read_materials
from shapemorph.io.textures import find_obvious_picture, find_picture

_MATERIAL_LIBRARY = re.compile(rb"mtllib[ \t]+([^\r\n]+)")
_LONGEST_INDENT = 256
_TEXTURE_COMMENT = re.compile(rb"^comment[ \t]+TextureFile[ \t]+([^\r\n]+)", re.MULTILINE)


def mesh_sources(path: Path) -> tuple[Path, ...]:
    """List the mesh file, its material files and its pictures, as far as they exist.

    What is named but missing is left out: reading the mesh says what is wrong with it.

    Raises
    ------
    DataError
        If the mesh file itself is not there.
    """
    if not path.is_file():
        what = "is a directory" if path.is_dir() else "does not exist"
        raise DataError(f"mesh {path} {what}: expected a mesh file")
    named = list(_NAMED.get(path.suffix.lower(), _nothing)(path))
    if not any(source.suffix.lower() not in (".mtl", ".bin") for source in named):
        with contextlib.suppress(DataError, OSError):
            named.append(find_obvious_picture(path)[0])
    return (path, *dict.fromkeys(source for source in named if source.is_file()))


def _of_obj(path: Path) -> Iterator[Path]:
    """Material libraries of an OBJ file, the one of its own name, and their pictures."""
    for name in (*_libraries(path.read_bytes()), f"{path.stem}.mtl"):
        with contextlib.suppress(DataError, OSError):
            library, _ = find_picture(name, path.parent)
            yield library
            yield from _of_library(library)


def _libraries(data: bytes) -> Iterator[str]:
    """Names in the lines of an OBJ file that begin with mtllib, without cutting it into lines."""
    for match in _MATERIAL_LIBRARY.finditer(data):
        before = data[max(match.start() - _LONGEST_INDENT, 0) : match.start()]
        if not re.split(rb"[\r\n]", before)[-1].strip():
            yield decode_text(match.group(1)).strip()


def _of_library(library: Path) -> Iterator[Path]:
    for material in read_materials(library):
        if material.picture is not None:
            with contextlib.suppress(DataError, OSError):
                yield find_picture(material.picture, material.folder)[0]


def _of_ply(path: Path) -> Iterator[Path]:
    with path.open("rb") as stream:
        header = stream.read(65536).partition(b"end_header")[0]
    for match in _TEXTURE_COMMENT.finditer(header):
        with contextlib.suppress(DataError, OSError):
            yield find_picture(decode_text(match.group(1)).strip(), path.parent)[0]


def _of_gltf(path: Path) -> Iterator[Path]:
    with contextlib.suppress(ValueError, AttributeError, TypeError):
        document = json.loads(path.read_bytes())
        for entry in (*document.get("buffers", ()), *document.get("images", ())):
            uri = entry.get("uri", "data:")
            if not uri.startswith("data:"):
                yield path.parent / unquote(uri)


def _nothing(path: Path) -> Iterator[Path]:  # noqa: ARG001
    return iter(())


_NAMED = {".obj": _of_obj, ".ply": _of_ply, ".gltf": _of_gltf}
