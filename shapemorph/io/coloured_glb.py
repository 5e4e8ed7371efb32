"""Write a surface coloured by a scalar as binary glTF 2.0."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapemorph.core.arrays import Floats, Ints
from shapemorph.methods.colour_maps import SEQUENTIAL, colours_of
from shapemorph.methods.vertex_normals import vertex_normals

_FLOAT, _UNSIGNED_SHORT, _UNSIGNED_INT = 5126, 5123, 5125
_ARRAY_BUFFER, _ELEMENT_BUFFER = 34962, 34963
_JSON_CHUNK, _BINARY_CHUNK = 0x4E4F534A, 0x004E4942


def write_coloured_glb(
    path: Path,
    positions: Floats,
    faces: Ints,
    scalar: tuple[str, Floats],
    extras: dict[str, Any],
) -> None:
    """Write a surface with a colour and the scalar behind it at every vertex.

    Parameters
    ----------
    path : Path
    positions : (V, 3)
        Metres, as glTF asks; axes as they come.
    faces : (F, 3)
    scalar : (name, (V,))
        The name starts with an underscore, as glTF asks of attributes of one's own.
    extras : dict
        JSON-able; stands at the mesh and at the file. The colours span `range` in it.
    """
    name, values = scalar
    low, high = extras["range"]
    share = (values - low) / (high - low) if high > low else np.zeros_like(values)
    buffers = [
        ("POSITION", positions.astype("<f4")),
        ("NORMAL", np.nan_to_num(vertex_normals(positions, faces, passes=0)).astype("<f4")),
        ("COLOR_0", _colours(share)),
        (name, values.astype("<f4")),
        ("indices", faces.astype("<u4").ravel()),
    ]
    document, binary = _document(buffers, {**extras, "colour_map": SEQUENTIAL})
    path.write_bytes(_container(document, binary))


def _colours(share: Floats) -> NDArray[np.uint16]:
    """Colours of values in [0, 1]; glTF wants them linear, colour maps are sRGB, (V, 4)."""
    encoded = colours_of(SEQUENTIAL)
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    table = np.append(np.round(linear * 65535), np.full((len(linear), 1), 65535), axis=1)
    step = np.clip((np.nan_to_num(share) * len(table)).astype(np.int64), 0, len(table) - 1)
    return table.astype("<u2")[step]


def _document(
    buffers: list[tuple[str, NDArray[Any]]], extras: dict[str, Any]
) -> tuple[dict[str, Any], bytes]:
    """Describe buffers laid one after the other; every item is a multiple of four bytes."""
    views, accessors, binary = [], [], b""
    for name, data in buffers:
        target = _ELEMENT_BUFFER if name == "indices" else _ARRAY_BUFFER
        length = data.nbytes
        views.append(
            {"buffer": 0, "byteOffset": len(binary), "byteLength": length, "target": target}
        )
        accessors.append(_accessor(name, data, len(views) - 1))
        binary += data.tobytes()
    attributes = {name: k for k, (name, _) in enumerate(buffers) if name != "indices"}
    primitive = {"attributes": attributes, "indices": len(buffers) - 1, "material": 0}
    material = {
        "doubleSided": True,
        "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.9},
    }
    document = {
        "asset": {"version": "2.0", "generator": "shapemorph"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "deformed"}],
        "meshes": [{"name": "deformed", "primitives": [primitive], "extras": extras}],
        "materials": [material],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
        "extras": extras,
    }
    return document, binary


def _accessor(name: str, data: NDArray[Any], view: int) -> dict[str, Any]:
    kinds = {"f4": _FLOAT, "u2": _UNSIGNED_SHORT, "u4": _UNSIGNED_INT}
    width = 1 if data.ndim == 1 else data.shape[1]
    accessor: dict[str, Any] = {
        "bufferView": view,
        "componentType": kinds[data.dtype.str[1:]],
        "count": len(data),
        "type": {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[width],
    }
    if name == "COLOR_0":
        accessor["normalized"] = True
    if name == "POSITION":
        accessor |= {"min": data.min(axis=0).tolist(), "max": data.max(axis=0).tolist()}
    return accessor


def _container(document: dict[str, Any], binary: bytes) -> bytes:
    """Join both parts in a GLB container, each padded to four bytes as the format asks."""
    text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    length = 12 + 8 + len(text) + 8 + len(binary)
    header = struct.pack("<4sII", b"glTF", 2, length)
    return b"".join(
        [
            header,
            struct.pack("<II", len(text), _JSON_CHUNK),
            text,
            struct.pack("<II", len(binary), _BINARY_CHUNK),
            binary,
        ]
    )
