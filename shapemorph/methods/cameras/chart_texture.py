"""The texture of a mesh from photographs, painted on its own chart."""

from collections.abc import Sequence

import numpy as np

from shapemorph.core.errors import StageError
from shapemorph.core.mesh import TexturedMesh, textured_mesh
from shapemorph.kernels.raster import rasterise
from shapemorph.methods.calibrating import continue_outside
from shapemorph.methods.cameras.averaged_grey import Photograph, average_grey
from shapemorph.methods.charting import chart_at_scale, picture_shape, to_unit_scale
from shapemorph.methods.distortion import chart_handedness
from shapemorph.methods.parametrize.boundary_first import parametrise_boundary_first
from shapemorph.methods.parametrize.disk import cut_pieces
from shapemorph.methods.vertex_normals import vertex_normals

_CALMING = 2  # passes over the normals


def texture_from(
    mesh: TexturedMesh, photographs: Sequence[Photograph], *, px_per_mm: float
) -> TexturedMesh:
    """Lay a mesh flat and average the grey of photographs over the picture that it makes.

    The map is conformal; only the largest connected piece is kept.

    Parameters
    ----------
    mesh : TexturedMesh
        Faces counter-clockwise seen from outside.
    photographs : sequence of Photograph
    px_per_mm : float
        Of the texture, median over the area.

    Raises
    ------
    StageError
        If no photograph shows any of it, or it cannot be laid flat.
    """
    piece = cut_pieces(mesh.vertices, mesh.faces, name=mesh.name)[0]
    plane = parametrise_boundary_first(mesh.vertices[piece.vertex_ids], piece.faces)
    plane = to_unit_scale(mesh.vertices, piece, plane)
    chart = chart_at_scale(piece, plane, px_per_mm=px_per_mm)
    height, width = picture_shape(chart)
    sign = chart_handedness(chart)
    covered, barycentric, _ = rasterise(chart.vertex_px, chart.faces, sign, height, width)
    inside = covered >= 0
    triangle = covered[inside]
    second, third = barycentric[inside].T
    weights = np.stack([1 - second - third, second, third], axis=-1)[..., None]
    corners = chart.vertex_ids[chart.faces[triangle]]
    normals = vertex_normals(mesh.vertices, mesh.faces, passes=_CALMING)
    points = (mesh.vertices[corners] * weights).sum(axis=1)
    upward = (normals[corners] * weights).sum(axis=1)
    upward /= np.maximum(np.linalg.norm(upward, axis=1, keepdims=True), 1e-12)
    seen, _ = average_grey(points, upward, photographs)
    known = np.isfinite(seen)
    if not known.any():
        raise StageError("no photograph shows the surface from in front: check the poses")
    grey = np.zeros(covered.shape, dtype=np.float32)
    mask = np.zeros(covered.shape, dtype=np.bool_)
    grey[inside] = np.where(known, seen, 0.0)
    mask[inside] = known
    uv = np.stack(
        [(chart.vertex_px[:, 0] + 0.5) / width, 1 - (chart.vertex_px[:, 1] + 0.5) / height],
        axis=-1,
    )
    faces = mesh.faces[chart.face_ids]
    return textured_mesh(
        mesh.vertices,
        faces,
        uv[chart.faces],
        np.zeros(len(faces), dtype=np.int64),
        (continue_outside(grey, mask),),
        name="mesh",
    )
