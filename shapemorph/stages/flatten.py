"""Stage `flatten`: textured meshes to calibrated images."""

import logging

import numpy as np

from shapemorph.config import FlattenConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.flattened import Distortion, FlattenedPair, FlattenedSurface
from shapemorph.core.mesh import TexturedMesh
from shapemorph.methods.calibrating import calibrate
from shapemorph.methods.charting import chart_at_scale, to_principal_axes, to_unit_scale
from shapemorph.methods.distortion import chart_distortion, local_scale, weighted_quantile
from shapemorph.methods.parametrize.automatic import (
    Flattening,
    flatten_automatically,
    judge,
    mend_and_judge,
)
from shapemorph.methods.parametrize.boundary_first import parametrise_boundary_first
from shapemorph.methods.parametrize.conformal_lscm import parametrise_lscm
from shapemorph.methods.parametrize.disk import Piece, boundary_loops, cut_piece, require_disk
from shapemorph.methods.parametrize.orthographic import parametrise_orthographic
from shapemorph.methods.scale import choose_scale, measure_pattern

logger = logging.getLogger(__name__)

MOST_LOST = 0.005  # share of the area that a sound map may flip or overlap
MOST_ANISOTROPY = 2.0  # ratio of stretches that 95 % of a sound map's area stays below
CONFORMAL = {"bff": parametrise_boundary_first, "lscm": parametrise_lscm}


def flatten(
    reference: TexturedMesh, deformed: TexturedMesh, config: FlattenConfig
) -> FlattenedPair:
    """Flatten both shapes, each at its own scale.

    Raises
    ------
    DataError
        For surfaces that cannot lie flat and textures without a pattern.
    StageError
        If nothing of a surface is left.
    """
    return FlattenedPair(flatten_mesh(reference, config), flatten_mesh(deformed, config))


def flatten_mesh(mesh: TexturedMesh, config: FlattenConfig) -> FlattenedSurface:
    """Make the calibrated image of one mesh.

    Parameters
    ----------
    mesh : TexturedMesh
        mm.
    config : FlattenConfig
        Section ``flatten`` of the run file.

    Raises
    ------
    DataError
        For a surface that cannot lie flat or a texture without a pattern.
    StageError
        If nothing of the surface is left.
    """
    piece = cut_piece(mesh.vertices, mesh.faces, name=mesh.name)
    flattening, why = _lay_flat(mesh, piece, config)
    plane = _place(mesh, piece, flattening)
    pattern = measure_pattern(mesh, piece, plane, max_megapixels=config.max_megapixels)
    px_per_mm, scale_reason = choose_scale(
        pattern,
        plane,
        speckle_px=config.speckle_px,
        max_megapixels=config.max_megapixels,
        px_per_mm=config.px_per_mm,
    )
    chart = chart_at_scale(piece, plane, px_per_mm=px_per_mm)
    image, overlap = calibrate(mesh, chart)
    distortion = chart_distortion(mesh.vertices, chart)
    reason = f"{why}; {scale_reason}; {_worst(distortion, px_per_mm)}"
    if overlap > MOST_LOST:
        logger.warning("%s: %.1f %% of the flattened image overlaps", mesh.name, 100 * overlap)
    logger.info("%s: %s", mesh.name, reason)
    return FlattenedSurface(
        calibrated=image,
        distortion=distortion,
        method=flattening.method,
        reason=reason,
        speckle_px=pattern.typical_chart_mm * px_per_mm,
        speckle_mm=pattern.typical_mm,
        texels_per_px=pattern.texels_per_mm / px_per_mm,
    )


def _lay_flat(mesh: TexturedMesh, piece: Piece, config: FlattenConfig) -> tuple[Flattening, str]:
    """Flatten one piece, in its own unit, and say how well it went."""
    vertices, faces = mesh.vertices[piece.vertex_ids], piece.faces
    if config.method == "orthographic":
        axis = None if config.axis is None else np.array(config.axis)
        plane = parametrise_orthographic(vertices, faces, axis=axis)
        flattening = judge(vertices, faces, plane, "orthographic")
    else:
        loops = boundary_loops(faces, name=mesh.name)
        require_disk(faces, loops, name=mesh.name)
        if config.method == "auto":
            return flatten_automatically(
                vertices, faces, most_lost=MOST_LOST, most_anisotropy=MOST_ANISOTROPY
            )
        plane = CONFORMAL[config.method](vertices, faces)
        flattening = mend_and_judge(vertices, faces, plane, config.method)
    return flattening, f"{flattening.describe()}, as asked"


def _place(mesh: TexturedMesh, piece: Piece, flattening: Flattening) -> Floats:
    """Turn and scale a map; a projection keeps its axes and its millimetres."""
    scaled = to_unit_scale(mesh.vertices, piece, flattening.plane)
    if flattening.method == "orthographic":
        return flattening.plane
    return to_principal_axes(mesh.vertices, piece, scaled)


def _worst(distortion: Distortion, px_per_mm: float) -> str:
    """Say how much coarser the worst hundredth of the surface is shown."""
    worst = weighted_quantile(local_scale(distortion), distortion.area, 0.01)
    return f"1 % of the surface has less than {worst:.3g} px/mm ({worst / px_per_mm:.0%})"
