"""PLY meshes with vertex colours or a texture, and PLY point clouds."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.io.file_mesh import FileMesh, bare_mesh, check_positions, cut_polygons
from shapemorph.io.greys import grey_of
from shapemorph.io.images import read_bytes
from shapemorph.io.ply_elements import Column, Table, read_elements
from shapemorph.io.point_cloud import mesh_of_points
from shapemorph.io.textures import find_obvious_picture, find_picture, load_textures

_UV_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t"))
_COLOUR_NAMES = (
    ("red", "green", "blue"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
    ("r", "g", "b"),
    ("intensity",),
    ("quality",),
    ("grey",),
    ("gray",),
    ("scalar",),
    ("scalar_intensity",),
)


def read_ply(path: Path, channel: str = "luma") -> FileMesh:
    """Read a PLY file: a texture where it names one, else vertex colours; meshed if a cloud.

    Raises
    ------
    DataError
        If the file or its texture is missing or damaged, or there is no pattern.
    """
    header, tables = read_elements(read_bytes(path, what="mesh"), path.name)
    vertex, face = tables.get("vertex", {}), tables.get("face", {})
    vertices = _stacked(vertex, ("x", "y", "z"))
    if vertices is None or len(vertices) == 0:
        raise DataError(f"{path.name}: expected vertices with x, y and z, got none")
    grey, grey_note = _vertex_grey(vertex, path.name, channel)
    polygons = _polygons(face)
    if "tristrips" in tables:
        raise DataError(f"{path.name}: expected faces, got triangle strips: export triangles")
    if polygons is None:
        return _cloud(path, vertices, grey, grey_note)
    mesh, corner_row, polygon = _triangles(path, vertices, polygons)
    pictures = [c.split(None, 1)[1] for c in header.comments if _names_texture(c)]
    wedge_uv = _wedge_uv(vertex, face, mesh.faces, corner_row)
    if wedge_uv is not None and (pictures or grey is None):
        named = replace(mesh, wedge_uv=wedge_uv, face_texture=_texture_number(face, polygon))
        return _textured(path, named, pictures, channel)
    if grey is None:
        raise DataError(
            f"{path.name}: expected vertex colours or texture coordinates with a comment "
            "TextureFile, got neither: export the mesh with its colours"
        )
    lost = ["it names a texture but has no texture coordinates"] if pictures else []
    return mesh.coloured(grey[mesh.faces]).noted(*grey_note, *lost)


def _stacked(table: Table, names: tuple[str, ...]) -> Floats | None:
    """Columns side by side (R, C) as float64, or None if one is missing."""
    if any(name not in table for name in names):
        return None
    columns = [table[name] for name in names]
    if any((column.counts != 1).any() for column in columns):
        return None
    return np.stack([column.values.astype(np.float64) for column in columns], axis=1)


def _vertex_grey(vertex: Table, name: str, channel: str) -> tuple[Floats | None, list[str]]:
    """Grey (V,) from the first set of properties that holds a pattern."""
    spare = None
    for names in _COLOUR_NAMES:
        if _stacked(vertex, names) is None:
            continue
        stored = np.stack([vertex[n].values for n in names], axis=1)
        used = stored if len(names) == 3 else stored[:, 0]
        grey = grey_of(used, name=f"{name} ({names[0]})", channel=channel)
        note = [] if len(names) == 3 else [f"grey is the vertex property {names[0]}"]
        if np.ptp(grey) > 0:
            return grey, note
        spare = grey if spare is None else spare
    return spare, []


def _cloud(path: Path, points: Floats, grey: Floats | None, notes: list[str]) -> FileMesh:
    if grey is None:
        raise DataError(
            f"{path.name}: expected faces or points with colour or intensity, got bare points: "
            "export them with their grey values"
        )
    return mesh_of_points(points, grey, name=path.name, file_format="PLY").noted(*notes)


def _polygons(face: Table) -> Column | None:
    """Corners of the faces; None where there are no faces."""
    column = next((face[n] for n in ("vertex_indices", "vertex_index") if n in face), None)
    return None if column is None or len(column.counts) == 0 else column


def _triangles(path: Path, vertices: Floats, column: Column) -> tuple[FileMesh, Ints, Ints]:
    """Triangles, the corner of the file that each of theirs is, and their polygon."""
    index = column.values.astype(np.int64)
    polygons = np.flatnonzero(column.counts >= 3)
    kept = np.flatnonzero(np.repeat(column.counts >= 3, column.counts))
    check_positions(vertices, index[kept], name=path.name)
    sizes = column.counts[polygons]
    corners, polygon = cut_polygons(vertices, index[kept], sizes, name=path.name)
    rows = kept[corners]
    split = int((column.counts > 3).sum())
    mesh = bare_mesh(vertices, index[rows], file_format="PLY", polygons_split=split)
    return mesh, rows, polygons[polygon]


def _wedge_uv(vertex: Table, face: Table, faces: Ints, corner_row: Ints) -> Floats | None:
    """Texture coordinates of corners, from lists on the faces or from the vertices."""
    polygons = _polygons(face)
    if "texcoord" in face and polygons is not None:
        sizes, lists = polygons.counts, face["texcoord"]
        whole = lists.counts == 2 * sizes
        pairs = np.full((int(sizes.sum()), 2), np.nan)
        values = lists.values[np.repeat(whole, lists.counts)].astype(np.float64)
        pairs[np.repeat(whole, sizes)] = values.reshape(-1, 2)
        return pairs[corner_row]
    found = (_stacked(vertex, names) for names in _UV_NAMES)
    uv = next((pair for pair in found if pair is not None), None)
    return None if uv is None else uv[faces]


def _texture_number(face: Table, polygon: Ints) -> Ints:
    """Picture of each triangle; 0 where the file does not say."""
    number = _stacked(face, ("texnumber",))
    return np.zeros(len(polygon), np.int64) if number is None else number[polygon, 0].astype(int)


def _names_texture(comment: str) -> bool:
    words = comment.split(None, 1)
    return len(words) == 2 and words[0].lower() == "texturefile"


def _textured(path: Path, mesh: FileMesh, pictures: list[str], channel: str) -> FileMesh:
    """Lay the textures on faces that know their UVs and numbers."""
    if pictures:
        found = [find_picture(named.strip('" '), path.parent) for named in pictures]
    else:
        found = [find_obvious_picture(path)]
    number, textures = mesh.face_texture, load_textures([each for each, _ in found], channel)
    known = np.where((number >= 0) & (number < len(textures)), number, -1)
    notes = [note for _, note in found if note]
    return mesh.noted(*notes).textured(mesh.wedge_uv, known, textures, "repeat")
