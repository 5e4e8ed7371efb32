"""The data of a glTF file: its JSON, buffers, accessors and pictures."""

import base64
import binascii
import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from shapemorph.core.errors import DataError
from shapemorph.io.images import Picture, decode_picture, read_bytes

_COMPONENTS: Mapping[int, str] = MappingProxyType(
    {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
)
_WIDTHS: Mapping[str, int] = MappingProxyType({"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4})
_MAX_ZEROS = 10_000_000  # rows that an accessor may claim without data
_GLB_JSON, _GLB_BINARY = 0x4E4F534A, 0x004E4942

_COMPRESSED: Mapping[str, str] = MappingProxyType(
    {
        "KHR_draco_mesh_compression": "Draco",
        "EXT_meshopt_compression": "meshopt",
        "KHR_meshopt_compression": "meshopt",
    }
)
_UNDERSTOOD = (
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_animation_pointer",
)


@dataclass(frozen=True, slots=True)
class GltfFile:
    """A glTF or GLB file with its JSON parsed.

    Attributes
    ----------
    name : str
    folder : Path
        Where external buffers and pictures lie.
    json : dict
    binary : bytes
        Binary chunk of a GLB file, empty otherwise.
    buffers : dict
        Buffers that have been read, by number.
    """

    name: str
    folder: Path
    json: dict[str, Any]
    binary: bytes
    buffers: dict[int, bytes] = field(default_factory=dict)


def open_gltf(path: Path) -> GltfFile:
    """Parse the container and refuse what cannot be read.

    Raises
    ------
    DataError
        If the file is damaged, of version 1, or its geometry is compressed.
    """
    data = read_bytes(path, what="mesh")
    text, binary = _glb_chunks(data, path.name) if data.startswith(b"glTF") else (data, b"")
    try:
        document = json.loads(text.decode("utf-8-sig"))
    except (ValueError, RecursionError):
        raise DataError(
            f"{path.name}: expected the JSON of a glTF file, got damaged text"
        ) from None
    if not isinstance(document, dict):
        raise DataError(f"{path.name}: expected a glTF object, got something else")
    _check_extensions(document, path.name)
    return GltfFile(path.name, path.parent, document, binary)


def _glb_chunks(data: bytes, name: str) -> tuple[bytes, bytes]:
    """JSON and binary chunk of a GLB file."""
    version, length = struct.unpack_from("<II", data.ljust(12, b"\0"), 4)
    if version != 2:
        raise DataError(f"{name}: expected glTF version 2, got {version}: export it again as GLB 2")
    if length > len(data):
        raise _truncated(name, length, len(data))
    chunks: dict[int, bytes] = {}
    place = 12
    while place + 8 <= length:
        size, kind = struct.unpack_from("<II", data, place)
        if place + 8 + size > length:
            raise _truncated(name, place + 8 + size, length)
        chunks.setdefault(kind, data[place + 8 : place + 8 + size])
        place += 8 + size
    if _GLB_JSON not in chunks:
        raise DataError(f"{name}: expected a GLB file with a JSON chunk, got none")
    return chunks[_GLB_JSON], chunks.get(_GLB_BINARY, b"")


def _truncated(name: str, wanted: int, got: int) -> DataError:
    return DataError(
        f"{name}: expected {wanted} bytes, got {got}: the file is truncated, copy or export it "
        "again"
    )


def _check_extensions(document: dict[str, Any], name: str) -> None:
    required = document.get("extensionsRequired", [])
    for extension in required if isinstance(required, list) else []:
        if extension in _COMPRESSED:
            raise compressed(name, str(extension))
        if extension not in _UNDERSTOOD and not str(extension).startswith("KHR_materials_"):
            raise DataError(
                f"{name}: expected a plain glTF file, got one that requires {str(extension)[:60]}: "
                "export it without this extension"
            )


def compressed(name: str, extension: str) -> DataError:
    """Make the refusal of compressed geometry."""
    return DataError(
        f"{name}: expected plain geometry, got {_COMPRESSED.get(extension, extension)} compression "
        f"({extension}): export it without compression (gltf-transform copy IN OUT also removes it)"
    )


def read_buffer(file: GltfFile, index: int) -> bytes:
    """Bytes of a buffer: the binary chunk, a data URI or a file."""
    if index in file.buffers:
        return file.buffers[index]
    entry = file.json["buffers"][index]
    uri = entry.get("uri")
    data = file.binary if uri is None else read_uri(file, uri, what="buffer")
    wanted = int(entry["byteLength"])
    if len(data) < wanted:
        raise _truncated(f"{file.name}, buffer {index}", wanted, len(data))
    file.buffers[index] = data
    return data


def read_uri(file: GltfFile, uri: str, *, what: str) -> bytes:
    """Bytes behind a data URI or a relative file name."""
    if uri.startswith("data:"):
        head, comma, body = uri.partition(",")
        try:
            if not comma or not head.endswith(";base64"):
                raise ValueError(head)  # noqa: TRY301 one message for both
            return base64.b64decode(body, validate=True)
        except (ValueError, binascii.Error):
            raise DataError(f"{file.name}: expected base64 data for a {what}, got damage") from None
    return read_bytes(file.folder / unquote(uri), what=what)


def read_view(file: GltfFile, index: int) -> tuple[bytes, int | None]:
    """Bytes of a buffer view, and its stride if it states one."""
    view = file.json["bufferViews"][index]
    if set(view.get("extensions", {})) & set(_COMPRESSED) and "buffer" not in view:
        raise compressed(file.name, next(iter(view["extensions"])))
    start, length = int(view.get("byteOffset", 0)), int(view["byteLength"])
    data = read_buffer(file, int(view["buffer"]))
    if min(start, length) < 0 or start + length > len(data):
        raise _truncated(f"{file.name}, buffer view {index}", start + length, len(data))
    return data[start : start + length], view.get("byteStride")


def read_accessor(file: GltfFile, index: int) -> NDArray[Any]:
    """Array (N, C) of an accessor; normalised integers become float64."""
    entry = file.json["accessors"][index]
    kind, width = np.dtype(_COMPONENTS[entry["componentType"]]), _WIDTHS[entry["type"]]
    count = int(entry["count"])
    if "bufferView" in entry:
        values = _elements(file, entry, kind, width, count)
    elif 0 <= count <= _MAX_ZEROS:
        values = np.zeros((count, width), dtype=kind)
    else:
        raise DataError(f"{file.name}: expected data for accessor {index}, got a count of {count}")
    if "sparse" in entry:
        values = _with_sparse(file, entry["sparse"], values)
    if entry.get("normalized") and kind.kind != "f":
        full = float(np.iinfo(kind).max)
        return np.maximum(values.astype(np.float64) / full, -1.0)
    return values.astype(kind.newbyteorder("="))


def _elements(
    file: GltfFile, entry: Mapping[str, Any], kind: np.dtype[Any], width: int, count: int
) -> NDArray[Any]:
    """Elements (count, width) in a buffer view."""
    data, stride = read_view(file, int(entry["bufferView"]))
    size = kind.itemsize * width
    step, start = int(stride or size), int(entry.get("byteOffset", 0))
    if (
        min(count, start) < 0
        or step < size
        or (count and start + (count - 1) * step + size > len(data))
    ):
        raise DataError(
            f"{file.name}: expected {count} elements of {size} bytes, got a buffer view of "
            f"{len(data)} bytes: the file is damaged, export it again"
        )
    raw = np.frombuffer(data, dtype=np.uint8)[start:]
    rows = as_strided(raw, (count, size), (step, 1), writeable=False)
    return np.ascontiguousarray(rows).view(kind).reshape(count, width)


def _with_sparse(file: GltfFile, sparse: Mapping[str, Any], values: NDArray[Any]) -> NDArray[Any]:
    """Replace the elements that a sparse accessor lists."""
    count, where = int(sparse["count"]), sparse["indices"]
    kind = np.dtype(_COMPONENTS[where["componentType"]])
    rows = _elements(file, where, kind, 1, count)[:, 0].astype(np.int64)
    replaced = values.copy()
    replaced[rows] = _elements(file, sparse["values"], values.dtype, values.shape[1], count)
    return replaced


def read_texture(file: GltfFile, index: int, channel: str) -> Picture:
    """Decode the picture of a texture."""
    entry = file.json["textures"][index]
    webp = entry.get("extensions", {}).get("EXT_texture_webp", {})
    source = webp.get("source", entry.get("source"))
    if source is None:
        names = ", ".join(entry.get("extensions", {})) or "none"
        raise DataError(
            f"{file.name}: expected a PNG or JPEG texture, got a source in {names[:80]}: export "
            "it with PNG or JPEG textures"
        )
    image = file.json["images"][source]
    if "uri" in image:
        label = "" if image["uri"].startswith("data:") else f" {unquote(image['uri'])}"
        data = read_uri(file, image["uri"], what="texture")
    else:
        label, (data, _) = "", read_view(file, int(image["bufferView"]))
    return decode_picture(data, name=f"{file.name}, texture{label or f' {index}'}", channel=channel)


def children_of(entry: Mapping[str, Any], key: str) -> Sequence[int]:
    """Node numbers listed under a key."""
    return [int(child) for child in entry.get(key, [])]
