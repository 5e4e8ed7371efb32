"""Any mesh file to one clean textured surface in mm."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from shapemorph.core.errors import ConfigError, DataError
from shapemorph.core.mesh import TexturedMesh, coloured_mesh, textured_mesh
from shapemorph.core.meshreport import MeshReport
from shapemorph.io.file_mesh import FileMesh
from shapemorph.io.gltf import read_gltf
from shapemorph.io.obj import read_obj
from shapemorph.io.ply import read_ply
from shapemorph.io.point_cloud import read_table
from shapemorph.io.textures import check_not_blank, into_pictures
from shapemorph.methods.cleaning import CleaningCounts, CleanSurface, clean_surface

MM_PER_UNIT: Mapping[str, float] = MappingProxyType(
    {"mm": 1.0, "um": 1e-3, "cm": 10.0, "m": 1000.0, "in": 25.4}
)

READERS: Mapping[str, Callable[[Path, str], FileMesh]] = MappingProxyType(
    {
        ".obj": read_obj,
        ".ply": read_ply,
        ".glb": read_gltf,
        ".gltf": read_gltf,
        ".csv": read_table,
        ".txt": read_table,
        ".xyz": read_table,
    }
)

# Two vertices are one within a millionth of the object: single precision keeps seven digits.
_WELD_TOLERANCE = 1e-6
# A face lower than this share of its longest side has no direction that numbers can tell.
_FLATNESS = 1e-9
# Pieces of a smaller share of the area are crumbs of the scan.
_LEAST_PIECE = 0.02


def read_mesh(path: Path, *, unit: str, channel: str = "luma") -> tuple[TexturedMesh, MeshReport]:
    """Read a textured mesh or a coloured point cloud.

    Parameters
    ----------
    path : Path
        OBJ, PLY, GLB, glTF, or a table of points (CSV, TXT, XYZ).
    unit : {"mm", "um", "cm", "m", "in"}
        Of the lengths in the file, whatever its format.
    channel : {"luma", "red", "green", "blue"}
        What of its colours becomes grey.

    Returns
    -------
    mesh : TexturedMesh
        In mm: welded, without degenerate or duplicate faces and crumbs, oriented.
    report : MeshReport
        What was found and mended.

    Raises
    ------
    DataError
        If the file is missing, damaged, empty, or carries no pattern.
    ConfigError
        If the unit is unknown.
    """
    if unit not in MM_PER_UNIT:
        raise ConfigError(f"expected a unit of {', '.join(MM_PER_UNIT)}, got {unit!r}")
    loose = _with_pattern_only(_reader(path)(path, channel), path.name)
    try:
        surface = clean_surface(
            loose.vertices,
            loose.faces,
            weld_tolerance=_WELD_TOLERANCE,
            flatness=_FLATNESS,
            least_piece=_LEAST_PIECE,
        )
    except DataError as error:
        raise DataError(f"{path.name}: {error}") from None
    kept = _on_surface(loose, surface)
    if kept.textures:
        kept = into_pictures(kept, path.name)
    check_not_blank(kept, path.name)
    report = _report(kept, surface.counts, path.name, unit)
    return _mesh(kept, path.name, unit), replace(report, channel=channel)


def _reader(path: Path) -> Callable[[Path, str], FileMesh]:
    suffix = path.suffix.lower()
    if path.is_dir():
        raise DataError(f"expected a mesh file, got the folder {path}: name the file in it")
    if not path.exists():
        raise DataError(f"mesh file {path} does not exist: check the path")
    if suffix in READERS:
        return READERS[suffix]
    known = ", ".join(sorted(READERS))
    if suffix == ".stl":
        raise DataError(
            f"{path.name}: expected a mesh with a pattern, got STL, which cannot store colour or "
            f"texture: export it as one of {known}"
        )
    raise DataError(f"{path.name}: expected one of {known}, got {suffix or 'no suffix'}: export it")


def _with_pattern_only(mesh: FileMesh, name: str) -> FileMesh:
    """Leave out faces that have no texture on a mesh that has textures."""
    if len(mesh.faces) == 0:
        raise DataError(f"{name}: expected triangles, got none: export the whole surface")
    if not mesh.textures:
        return mesh
    bare = (mesh.face_texture < 0) | np.isnan(mesh.wedge_uv).any(axis=(1, 2))
    if not bare.any():
        return mesh
    if bare.all():
        raise DataError(
            f"{name}: expected texture coordinates on its faces, got none that are complete: "
            "export the mesh with UVs"
        )
    note = f"{int(bare.sum())} of {len(bare)} faces have no texture and were left out"
    return mesh.only(np.flatnonzero(~bare)).noted(note)


def _on_surface(mesh: FileMesh, surface: CleanSurface) -> FileMesh:
    """Carry texture or grey over to the cleaned faces, corner by corner."""
    moved = replace(mesh, vertices=surface.vertices, faces=surface.faces)
    if mesh.textures:
        return replace(
            moved,
            wedge_uv=mesh.wedge_uv.reshape(-1, 2)[surface.corners],
            face_texture=mesh.face_texture[surface.corners[:, 0] // 3],
        )
    return replace(moved, corner_grey=mesh.corner_grey.ravel()[surface.corners])


def _mesh(mesh: FileMesh, name: str, unit: str) -> TexturedMesh:
    vertices = mesh.vertices * MM_PER_UNIT[unit]
    if mesh.textures:
        return textured_mesh(
            vertices, mesh.faces, mesh.wedge_uv, mesh.face_texture, mesh.textures, name=name
        )
    coloured = coloured_mesh(vertices, mesh.faces, mesh.corner_grey, name=name)
    return replace(coloured, sided=mesh.grey_source != "point cloud")


def _report(mesh: FileMesh, counts: CleaningCounts, name: str, unit: str) -> MeshReport:
    return MeshReport(
        name=name,
        file_format=mesh.file_format,
        method=mesh.method,
        vertices=len(mesh.vertices),
        faces=len(mesh.faces),
        welded_vertices=counts.welded_vertices,
        unreferenced_vertices=counts.unreferenced_vertices,
        degenerate_faces=counts.degenerate_faces,
        duplicate_faces=counts.duplicate_faces,
        non_manifold_faces=counts.non_manifold_faces,
        polygons_split=mesh.polygons_split,
        components=counts.components,
        dropped_faces=counts.dropped_faces,
        boundary_loops=counts.boundary_loops,
        euler_characteristic=counts.euler_characteristic,
        texture_sizes=tuple((t.shape[0], t.shape[1]) for t in mesh.textures),
        grey_source=mesh.grey_source,
        content=mesh.content,
        unit=unit,
        notes=(*mesh.notes, *_explanations(counts)),
    )


def _explanations(counts: CleaningCounts) -> list[str]:
    """One sentence for every count that a user should know about."""
    notes = []
    if counts.components > counts.kept_components:
        notes.append(
            f"{counts.components} connected pieces: those of at least {_LEAST_PIECE:.0%} of the "
            f"area are kept ({counts.kept_components}), {counts.dropped_faces} faces of the "
            "others were dropped"
        )
    elif counts.components > 1:
        notes.append(f"{counts.components} connected pieces, all kept")
    if counts.non_manifold_faces:
        notes.append(
            f"{counts.non_manifold_faces} faces were cut loose at edges of more than two faces"
        )
    if counts.split_vertices:
        notes.append(f"{counts.split_vertices} vertices added where faces met only at a point")
    if counts.turned_faces:
        notes.append(f"{counts.turned_faces} faces were turned over to agree with their neighbours")
    if counts.one_sided_edges:
        notes.append(f"cut along {counts.one_sided_edges} edges because the surface is one-sided")
    if counts.boundary_loops == 0:
        genus = (2 * counts.kept_components - counts.euler_characteristic) // 2
        notes.append(f"closed surface of genus {genus}")
    return notes
