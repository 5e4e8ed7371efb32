"""glTF and GLB: triangles of all nodes in one frame, with base colour textures or COLOR_0."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.io.file_mesh import FileMesh, Wrap, bare_mesh, check_positions
from shapemorph.io.gltf_data import (
    GltfFile,
    children_of,
    compressed,
    open_gltf,
    read_accessor,
    read_texture,
)
from shapemorph.io.point_cloud import mesh_of_points
from shapemorph.methods.colour_content import CHANNELS

_POINTS, _TRIANGLES, _STRIP, _FAN = 0, 4, 5, 6
_WRAPS: Mapping[int, Wrap] = {33071: "clamp", 33648: "mirror", 10497: "repeat"}
_MAX_ELEMENTS = 100_000_000  # faces and vertices


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """One primitive of one node, in the frame of the scene.

    `uv` is NaN and `texture` -1 where there is no texture; `grey` is NaN without colours.
    """

    vertices: Floats
    faces: Ints
    uv: Floats
    texture: int
    grey: Floats


def read_gltf(path: Path, channel: str = "luma") -> FileMesh:
    """Read a glTF or GLB file.

    Positions take the transforms of their nodes and otherwise stay as they are, whatever the
    unit. COLOR_0 is linear and becomes the stored values of a picture (sRGB) before it becomes
    grey.

    Raises
    ------
    DataError
        If the file is damaged or compressed, or there is no pattern.
    """
    file = open_gltf(path)
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused by the checks
            return _assembled(file, _all_parts(file, channel), channel)
    except DataError:
        raise
    except (KeyError, IndexError, TypeError, AttributeError, ValueError, OverflowError) as error:
        reason = f"{type(error).__name__}: {' '.join(str(error).split())[:80]}"
        raise DataError(
            f"{path.name}: expected a valid glTF file, got one that contradicts itself ({reason}): "
            "export it again"
        ) from None


def _placed(file: GltfFile) -> Iterator[tuple[int, Floats]]:
    """Meshes of the scene with their transforms (4, 4)."""
    document = file.json
    nodes = document.get("nodes", [])
    if not nodes:
        yield from ((mesh, np.eye(4)) for mesh in range(len(document.get("meshes", []))))
        return
    waiting = [(root, np.eye(4)) for root in reversed(_roots(document, nodes))]
    seen: set[int] = set()
    while waiting:
        index, above = waiting.pop()
        if index in seen:
            raise DataError(f"{file.name}: expected a tree of nodes, got node {index} twice")
        seen.add(index)
        matrix = above @ _matrix(nodes[index])
        if "mesh" in nodes[index]:
            yield int(nodes[index]["mesh"]), matrix
        waiting += [(child, matrix) for child in reversed(children_of(nodes[index], "children"))]


def _roots(document: Mapping[str, Any], nodes: list[Any]) -> list[int]:
    scenes = document.get("scenes", [])
    if scenes:
        return list(children_of(scenes[int(document.get("scene", 0))], "nodes"))
    below = {child for node in nodes for child in children_of(node, "children")}
    return [index for index in range(len(nodes)) if index not in below]


def _matrix(node: Mapping[str, Any]) -> Floats:
    """Transform (4, 4) of one node into the frame above."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    turn = Rotation.from_quat(np.array(node.get("rotation", [0, 0, 0, 1]), dtype=np.float64))
    matrix[:3, :3] = turn.as_matrix() * np.array(node.get("scale", [1, 1, 1]), dtype=np.float64)
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def _all_parts(file: GltfFile, channel: str) -> list[_Part]:
    """Parts of all nodes; a mesh may be placed many times, so their sum is bounded."""
    parts: list[_Part] = []
    total = 0
    for mesh, matrix in _placed(file):
        for part in _parts(file, mesh, matrix, channel):
            parts.append(part)
            total += len(part.faces) + len(part.vertices)
            if total > _MAX_ELEMENTS:
                raise DataError(f"{file.name}: expected up to {_MAX_ELEMENTS} elements, got more")
    return parts


def _parts(file: GltfFile, mesh: int, matrix: Floats, channel: str) -> Iterator[_Part]:
    for primitive in file.json["meshes"][mesh]["primitives"]:
        if primitive.get("mode", _TRIANGLES) in (_POINTS, _TRIANGLES, _STRIP, _FAN):
            yield _part(file, primitive, matrix, channel)


def _part(file: GltfFile, primitive: Mapping[str, Any], matrix: Floats, channel: str) -> _Part:
    attributes = primitive["attributes"]
    if "KHR_draco_mesh_compression" in primitive.get("extensions", {}):
        raise compressed(file.name, "KHR_draco_mesh_compression")
    local = read_accessor(file, attributes["POSITION"]).astype(np.float64)
    vertices = local[:, :3] @ matrix[:3, :3].T + matrix[:3, 3]
    faces = _faces(file, primitive, len(vertices))
    if len(faces):
        check_positions(vertices, faces.ravel(), name=file.name)
    if np.linalg.det(matrix[:3, :3]) < 0:
        faces = faces[:, ::-1]
    uv, texture = _texture_coordinates(file, primitive, len(vertices))
    return _Part(vertices, faces, uv, texture, _grey(file, attributes, len(vertices), channel))


def _faces(file: GltfFile, primitive: Mapping[str, Any], count: int) -> Ints:
    """Triangles (F, 3) of a primitive; none for points."""
    if "indices" in primitive:
        index = read_accessor(file, primitive["indices"])[:, 0].astype(np.int64)
    else:
        index = np.arange(count)
    mode = primitive.get("mode", _TRIANGLES)
    if mode == _TRIANGLES:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    if mode == _POINTS or len(index) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    if mode == _FAN:
        return np.stack([np.full(len(index) - 2, index[0]), index[1:-1], index[2:]], axis=1)
    strip = np.stack([index[:-2], index[1:-1], index[2:]], axis=1)
    strip[1::2] = strip[1::2, [1, 0, 2]]
    return strip


def _texture_coordinates(
    file: GltfFile, primitive: Mapping[str, Any], count: int
) -> tuple[Floats, int]:
    """Coordinates (N, 2), origin at the lower left, and the texture they look into."""
    info = _texture_info(file, primitive)
    transform = info.get("extensions", {}).get("KHR_texture_transform", {})
    name = f"TEXCOORD_{int(transform.get('texCoord', info.get('texCoord', 0)))}"
    if "index" not in info or name not in primitive["attributes"]:
        return np.full((count, 2), np.nan), -1
    stored = read_accessor(file, primitive["attributes"][name])[:count, :2].astype(np.float64)
    moved = _transformed(stored, transform)
    return np.stack([moved[:, 0], 1.0 - moved[:, 1]], axis=1), int(info["index"])


def _texture_info(file: GltfFile, primitive: Mapping[str, Any]) -> Mapping[str, Any]:
    """Find the texture that carries the colour, empty if there is none."""
    if "material" not in primitive:
        return {}
    material = file.json["materials"][primitive["material"]]
    older = material.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness", {})
    choices = (
        material.get("pbrMetallicRoughness", {}).get("baseColorTexture"),
        older.get("diffuseTexture"),
        material.get("emissiveTexture"),
    )
    return next((choice for choice in choices if choice), {})


def _transformed(uv: Floats, transform: Mapping[str, Any]) -> Floats:
    """Apply KHR_texture_transform: scale, turn (counter-clockwise where v points down), move."""
    if not transform:
        return uv
    scaled = uv * np.array(transform.get("scale", [1, 1]), dtype=np.float64)
    angle = float(transform.get("rotation", 0.0))
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    moved: Floats = scaled @ turn.T + np.array(transform.get("offset", [0, 0]), dtype=np.float64)
    return moved


def _grey(file: GltfFile, attributes: Mapping[str, Any], count: int, channel: str) -> Floats:
    """Grey (N,) of COLOR_0 as a picture would store it; NaN without it."""
    if "COLOR_0" not in attributes:
        return np.full(count, np.nan)
    colour = read_accessor(file, attributes["COLOR_0"])
    if colour.dtype.kind in "iu":  # integers that the file forgot to call normalised
        colour = colour / np.iinfo(colour.dtype).max
    linear = np.clip(colour[:count, :3].astype(np.float64), 0.0, 1.0)
    grey: Floats = _srgb(linear) @ CHANNELS[channel]
    return grey


def _srgb(linear: Floats) -> Floats:
    """Encode linear light as sRGB (IEC 61966-2-1)."""
    bright = 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, bright)


def _assembled(file: GltfFile, parts: list[_Part], channel: str) -> FileMesh:
    """Join the parts into one mesh, or one cloud where there are no faces."""
    if not parts or not any(len(part.vertices) for part in parts):
        raise DataError(f"{file.name}: expected a mesh in the scene, got none")
    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    vertices = np.concatenate([part.vertices for part in parts])
    faces = np.concatenate([p.faces + start for p, start in zip(parts, first, strict=False)])
    grey = np.concatenate([part.grey for part in parts])
    file_format = "GLB" if file.binary else "glTF"
    if len(faces) == 0:
        return _cloud(file, vertices, grey, file_format)
    mesh = bare_mesh(vertices, faces, file_format=file_format)
    texture = np.concatenate([np.full(len(part.faces), part.texture) for part in parts])
    if (texture >= 0).any():
        uv = np.concatenate([part.uv for part in parts])[faces]
        return _textured(file, replace(mesh, wedge_uv=uv), texture, channel)
    coloured = np.isfinite(grey[faces]).all(axis=1)
    if not coloured.any():
        raise DataError(
            f"{file.name}: expected a base colour texture or COLOR_0, got neither: export the mesh "
            "with its texture"
        )
    bare = int((~coloured).sum())
    notes = [f"{bare} of {len(faces)} faces have no colour and were left out"] if bare else []
    kept = replace(mesh, faces=faces[coloured])
    return kept.coloured(grey[kept.faces]).noted(*notes)


def _cloud(file: GltfFile, points: Floats, grey: Floats, file_format: str) -> FileMesh:
    if not np.isfinite(grey).all():
        raise DataError(f"{file.name}: expected faces or coloured points, got bare points")
    return mesh_of_points(points, grey, name=file.name, file_format=file_format)


def _textured(file: GltfFile, mesh: FileMesh, texture: Ints, channel: str) -> FileMesh:
    """Decode the textures in use and number them from 0."""
    used = np.unique(texture[texture >= 0])
    pictures = [read_texture(file, int(index), channel) for index in used]
    number = np.where(texture >= 0, np.searchsorted(used, texture), -1)
    return mesh.textured(mesh.wedge_uv, number, pictures, _wrap(file, int(used[0])))


def _wrap(file: GltfFile, texture: int) -> Wrap:
    """How the picture of a texture goes on beyond its border."""
    sampler = file.json["textures"][texture].get("sampler")
    entry = {} if sampler is None else file.json["samplers"][sampler]
    return _WRAPS.get(entry.get("wrapS", 10497), "repeat")
