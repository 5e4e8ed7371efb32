"""Writing textured meshes: OBJ + MTL + PNG, GLB, PLY with vertex colours.

Every format gets the same numbers: positions in the unit that the caller names. Files are
the same bytes for the same mesh.
"""

import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapemorph.core.arrays import Bools, Floats, Greys, Ints
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.core.mesh import TexturedMesh
from shapemorph.io.meshes import MM_PER_UNIT


def write_mesh(path: Path, mesh: TexturedMesh, *, unit: str = "mm") -> list[Path]:
    """Write a mesh in the format of the suffix (.obj, .glb, .ply); return the files written.

    Parameters
    ----------
    path : Path
        Beside an OBJ file, ``<stem>.mtl`` and ``<stem>.png`` (``<stem>_1.png`` and so on for
        further textures) are written.
    mesh : TexturedMesh
        In mm.
    unit : str
        Of the numbers in the file: mm, um, cm, m or in.

    Raises
    ------
    ConfigError
        If the suffix or the unit is unknown.
    DataError
        If the format cannot hold this kind of grey.
    """
    if unit not in MM_PER_UNIT:
        raise ConfigError(f"unit must be one of {', '.join(MM_PER_UNIT)}, got {unit!r}")
    writers = {".obj": _write_obj, ".glb": _write_glb, ".ply": _write_ply}
    if path.suffix.lower() not in writers:
        raise ConfigError(f"meshes are written as .obj, .glb or .ply, got {path.name}")
    return writers[path.suffix.lower()](path, mesh, mesh.vertices / MM_PER_UNIT[unit])


def encode_grey_png(grey: Greys) -> bytes:
    """PNG (8 bit, grey) of a picture (H, W) in [0, 1]."""
    levels = np.rint(np.clip(grey, 0, 1) * 255).astype(np.uint8)
    height, width = levels.shape
    above = np.concatenate([np.zeros((1, width), dtype=np.uint8), levels[:-1]])
    rows = np.empty((height, width + 1), dtype=np.uint8)
    rows[:, 0] = 2  # every row as the difference from the one above
    rows[:, 1:] = levels - above
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(_png_chunk(kind, data) for kind, data in chunks)


def _png_chunk(kind: bytes, data: bytes) -> bytes:
    check = zlib.crc32(kind + data)
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", check)


def _write_obj(path: Path, mesh: TexturedMesh, vertices: Floats) -> list[Path]:
    if not mesh.has_texture:
        raise DataError(f"{path.name}: OBJ needs a texture, this mesh has vertex colours: use .ply")
    pictures = [
        path.with_name(f"{path.stem}{f'_{k}' if k else ''}.png") for k in range(len(mesh.textures))
    ]
    material = path.with_suffix(".mtl")
    for picture, texture in zip(pictures, mesh.textures, strict=True):
        picture.write_bytes(encode_grey_png(texture))
    material.write_text(
        "".join(
            f"newmtl texture_{k}\nKd 1 1 1\nillum 0\nmap_Kd {picture.name}\n"
            for k, picture in enumerate(pictures)
        )
    )
    path.write_text(_obj_text(mesh, vertices, material.name))
    return [path, material, *pictures]


def _obj_text(mesh: TexturedMesh, vertices: Floats, material: str) -> str:
    places, corner = np.unique(
        np.round(mesh.wedge_uv.reshape(-1, 2), 7), axis=0, return_inverse=True
    )
    corner_rows = np.stack([mesh.faces, corner.reshape(-1, 3)], axis=-1).reshape(-1, 6) + 1
    lines = [
        f"mtllib {material}\n",
        _rows("v", vertices, _decimals(vertices)),
        _rows("vt", places, 7),
    ]
    for k in range(len(mesh.textures)):
        chosen = corner_rows[mesh.face_texture == k]
        faces = "f %d/%d %d/%d %d/%d\n" * len(chosen) % tuple(chosen.ravel().tolist())
        lines += [f"usemtl texture_{k}\n", faces]
    return "".join(lines)


def _decimals(vertices: Floats) -> int:
    """Decimals that resolve ten millionths of the size."""
    size = float(np.ptp(vertices, axis=0).max(initial=0.0)) or 1.0
    return max(0, int(np.ceil(7 - np.log10(size))))


def _rows(word: str, values: Floats, decimals: int) -> str:
    """One line per row of values, with so many decimals."""
    line = word + f" %.{decimals}f" * values.shape[1] + "\n"
    text: str = line * len(values) % tuple(values.ravel().tolist())
    return text


def _write_ply(path: Path, mesh: TexturedMesh, vertices: Floats) -> list[Path]:
    if mesh.has_texture:
        raise DataError(f"{path.name}: PLY is written with vertex colours only: use .obj or .glb")
    points, faces, grey = _split_by_grey(mesh, vertices)
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
        "property double x\nproperty double y\nproperty double z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.zeros(len(points), dtype=[("place", "<f8", 3), ("colour", "u1", 3)])
    rows["place"], rows["colour"] = points, grey[:, None]
    lists = np.zeros(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    lists["count"], lists["corners"] = 3, faces
    path.write_bytes(head.encode() + rows.tobytes() + lists.tobytes())
    return [path]


def _split_by_grey(mesh: TexturedMesh, vertices: Floats) -> tuple[Floats, Ints, NDArray[np.uint8]]:
    """Vertices, faces and grey with one vertex for each grey that meets at a point."""
    levels = np.rint(np.clip(mesh.corner_grey, 0, 1) * 255).astype(np.int64)
    pairs = np.stack([mesh.faces.ravel(), levels.ravel()], axis=1)
    unique, corner = np.unique(pairs, axis=0, return_inverse=True)
    return vertices[unique[:, 0]], corner.reshape(-1, 3), unique[:, 1].astype(np.uint8)


def _write_glb(path: Path, mesh: TexturedMesh, vertices: Floats) -> list[Path]:
    if not mesh.has_texture:
        raise DataError(f"{path.name}: GLB needs a texture, this mesh has vertex colours: use .ply")
    buffer = _GlbBuffer()
    primitives: list[dict[str, Any]] = []
    images: list[dict[str, Any]] = []
    for k, texture in enumerate(mesh.textures):
        primitives.append(_glb_primitive(buffer, mesh, vertices, mesh.face_texture == k, k))
        view = buffer.add(encode_grey_png(texture))
        images.append({"bufferView": view, "mimeType": "image/png"})
    document = buffer.document() | {
        "asset": {"version": "2.0", "generator": "shapemorph"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": primitives}],
        "materials": [_glb_material(k) for k in range(len(images))],
        "textures": [{"source": k} for k in range(len(images))],
        "images": images,
    }
    path.write_bytes(_glb_bytes(document, bytes(buffer.data)))
    return [path]


class _GlbBuffer:
    """The binary part of a GLB file while it grows, with its views and accessors."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, content: bytes) -> int:
        """Append bytes as a view of their own; return its number."""
        self.data += b"\0" * (-len(self.data) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(content)})
        self.data += content
        return len(self.views) - 1

    def add_array(self, values: NDArray[Any], kind: str) -> int:
        """Append an array of float32 or uint32 as an accessor; return its number."""
        component = 5126 if values.dtype == np.float32 else 5125
        accessor: dict[str, Any] = {
            "bufferView": self.add(np.ascontiguousarray(values).tobytes()),
            "componentType": component,
            "count": len(values),
            "type": kind,
        }
        if kind == "VEC3":
            accessor |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def document(self) -> dict[str, Any]:
        """Return the entries that describe the buffer."""
        return {
            "buffers": [{"byteLength": len(self.data)}],
            "bufferViews": self.views,
            "accessors": self.accessors,
        }


def _glb_primitive(
    buffer: _GlbBuffer, mesh: TexturedMesh, vertices: Floats, mine: Bools, texture: int
) -> dict[str, Any]:
    """Faces of one texture, with one vertex for each texture coordinate that meets at a point."""
    corners = np.concatenate(
        [mesh.faces[mine].reshape(-1, 1), mesh.wedge_uv[mine].reshape(-1, 2)], axis=1
    )
    unique, index = np.unique(corners, axis=0, return_inverse=True)
    uv = np.stack([unique[:, 1], 1 - unique[:, 2]], axis=1)  # glTF counts v from the top
    place = vertices[unique[:, 0].astype(np.int64)]
    return {
        "attributes": {
            "POSITION": buffer.add_array(place.astype(np.float32), "VEC3"),
            "TEXCOORD_0": buffer.add_array(uv.astype(np.float32), "VEC2"),
        },
        "indices": buffer.add_array(index.ravel().astype(np.uint32), "SCALAR"),
        "material": texture,
    }


def _glb_material(texture: int) -> dict[str, Any]:
    surface = {"baseColorTexture": {"index": texture}, "metallicFactor": 0, "roughnessFactor": 1}
    return {"pbrMetallicRoughness": surface, "doubleSided": True}


def _glb_bytes(document: dict[str, Any], binary: bytes) -> bytes:
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)
    head = struct.pack("<4sII", b"glTF", 2, total)
    text_head = struct.pack("<I4s", len(text), b"JSON")
    binary_head = struct.pack("<I4s", len(binary), b"BIN\0")
    return head + text_head + text + binary_head + binary
