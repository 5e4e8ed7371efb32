"""Wavefront OBJ with its materials and textures."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from shapemorph.core.arrays import Ints
from shapemorph.core.errors import DataError
from shapemorph.io.file_mesh import FileMesh, Wrap, bare_mesh, check_positions, cut_polygons
from shapemorph.io.greys import grey_of
from shapemorph.io.images import read_bytes
from shapemorph.io.mtl import Material, read_materials
from shapemorph.io.obj_text import (
    ObjLines,
    cut_lines,
    read_polygons,
    read_texture_coordinates,
    read_vertices,
)
from shapemorph.io.textures import find_obvious_picture, find_picture, load_textures


def read_obj(path: Path, channel: str = "luma") -> FileMesh:
    """Read an OBJ file: polygons, wedge UVs, materials, vertex colours.

    Raises
    ------
    DataError
        If the file, its material file or a texture is missing or damaged, or there is no
        pattern.
    """
    lines = cut_lines(read_bytes(path, what="mesh"), path.name)
    vertices, colours = read_vertices(lines)
    uv = read_texture_coordinates(lines)
    polygons = read_polygons(lines)
    check_positions(vertices, polygons.vertex, name=path.name)
    corners, polygon = cut_polygons(vertices, polygons.vertex, polygons.sizes, name=path.name)
    faces = polygons.vertex[corners]
    split = int((polygons.sizes > 3).sum())
    mesh = bare_mesh(vertices, faces, file_format="OBJ", polygons_split=split)
    wedge_row = polygons.uv[corners]
    if (wedge_row >= 0).any():
        wedge_uv = np.concatenate([uv, np.full((1, 2), np.nan)])[wedge_row]
        bare = replace(mesh, wedge_uv=wedge_uv)
        skinned = _skin(path, lines, polygons.line[polygon], bare, channel)
        if skinned is not None:
            return skinned
    if colours is None:
        raise _without_pattern(path, lines, has_uv=bool(len(uv)))
    return mesh.coloured(grey_of(colours, name=path.name, channel=channel)[faces])


def _skin(
    path: Path, lines: ObjLines, face_line: Ints, mesh: FileMesh, channel: str
) -> FileMesh | None:
    """Lay the textures on the faces, which know their UVs; None if no material has one."""
    materials, missing = _materials(path, lines)
    names, face_name = _material_names(lines, face_line)
    textured = {m.name: m for m in materials if m.picture}
    used = [textured.get(name) for name in names]
    if any(used[k] is not None for k in np.unique(face_name)):
        return _with_materials(mesh, used, face_name, channel)
    known = {m.name for m in materials}
    if len(textured) == 1 and not known.intersection(names):
        only = next(iter(textured.values()))
        note = f"faces name no known material; {only.name} is used, the only one with a texture"
        return _with_materials(mesh, [only] * len(names), face_name, channel).noted(note)
    if materials or len(lines.rows(b"v")) == 0:
        return None
    return _with_obvious_picture(path, mesh, missing, channel)


def _materials(path: Path, lines: ObjLines) -> tuple[list[Material], list[str]]:
    """All materials of the files that exist, and the names of those that do not."""
    found: list[Material] = []
    missing: list[str] = []
    for row in lines.rows(b"mtllib"):
        statement = lines.statement(int(row), "mtllib").strip('"')
        whole = _beside(path, statement)
        names = [statement] if whole is not None else statement.split()
        for name in names:
            library = _beside(path, name)
            if library is None:
                missing.append(name)
            else:
                found.extend(read_materials(library))
    return found, missing


def _beside(path: Path, named: str) -> Path | None:
    """Find a material file where the mesh says, or by its bare name beside the mesh."""
    try:
        return find_picture(named, path.parent)[0]
    except DataError:
        return None


def _material_names(lines: ObjLines, face_line: Ints) -> tuple[list[str], Ints]:
    """Names of materials in order of use, "" first, and the one of each face."""
    rows = lines.rows(b"usemtl")
    names = ["", *(lines.statement(int(row), "usemtl") for row in rows)]
    distinct = list(dict.fromkeys(names))
    number = {name: k for k, name in enumerate(distinct)}
    of_statement = np.array([number[name] for name in names])
    return distinct, of_statement[np.searchsorted(rows, face_line)]


def _with_materials(
    mesh: FileMesh, used: list[Material | None], face_name: Ints, channel: str
) -> FileMesh:
    """Lay the pictures of materials on the faces that use them; each picture is read once."""
    paths: dict[Path, int] = {}
    texture_of = np.full(len(used), -1)
    scale, offset = np.ones((len(used), 2)), np.zeros((len(used), 2))
    notes = []
    for k in np.unique(face_name):
        material = used[k]
        if material is None or material.picture is None:
            continue
        picture, note = find_picture(material.picture, material.folder)
        texture_of[k] = paths.setdefault(picture, len(paths))
        scale[k], offset[k] = material.scale, material.offset
        notes += [note] if note else []
    uv = mesh.wedge_uv
    if (scale != 1.0).any() or offset.any():
        with np.errstate(over="ignore"):  # infinite ones are refused later
            uv = uv * scale[face_name][:, None] + offset[face_name][:, None]
    clamped = any(m is not None and m.clamp for m in used)
    wrap: Wrap = "clamp" if clamped else "repeat"
    pictures = load_textures(list(paths), channel)
    return mesh.noted(*notes).textured(uv, texture_of[face_name], pictures, wrap)


def _with_obvious_picture(path: Path, mesh: FileMesh, missing: list[str], channel: str) -> FileMesh:
    picture, note = find_obvious_picture(path)
    lost = [f"material file {name} does not exist" for name in missing]
    face_texture = np.zeros(len(mesh.faces), dtype=np.int64)
    pictures = load_textures([picture], channel)
    return mesh.noted(*lost, note).textured(mesh.wedge_uv, face_texture, pictures, "repeat")


def _without_pattern(path: Path, lines: ObjLines, *, has_uv: bool) -> DataError:
    """Say what a mesh without pattern lacks."""
    if has_uv:
        libraries = ", ".join(lines.statement(int(r), "mtllib") for r in lines.rows(b"mtllib"))
        lack = f"materials without a picture ({libraries}): add a line map_Kd PICTURE to them"
    else:
        lack = "neither vt lines nor colours after v x y z: export the mesh with its texture"
    return DataError(f"{path.name}: expected a texture or vertex colours, got {lack}")
