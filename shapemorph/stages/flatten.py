"""Stage `flatten`: textured meshes to calibrated images."""

import logging

import numpy as np

from shapemorph.config import FlattenConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.flattened import Distortion, FlattenedPair, FlattenedSurface
from shapemorph.core.mesh import TexturedMesh
from shapemorph.methods.calibrating import calibrate
from shapemorph.methods.charting import chart_at_scale
from shapemorph.methods.distortion import chart_distortion, local_scale, weighted_quantile
from shapemorph.methods.parametrize.automatic import Flattening
from shapemorph.methods.parametrize.choice import lay_flat, place
from shapemorph.methods.parametrize.disk import Piece, cut_piece
from shapemorph.methods.scale import choose_scale, measure_pattern

logger = logging.getLogger(__name__)

MOST_LOST = 0.005  # share of the area that a sound map may flip or overlap
MOST_ANISOTROPY = 2.0  # ratio of stretches that 99 % of a sound map's area stays below
MOST_REDUCED = 4.0  # a sound map shows 99 % of the area at a quarter of the median scale or more


def flatten(
    reference: TexturedMesh,
    deformed: TexturedMesh,
    config: FlattenConfig,
    meridian: Floats | None = None,
) -> FlattenedPair:
    """Flatten both shapes, each at its own scale.

    Parameters
    ----------
    reference, deformed : TexturedMesh
        mm.
    config : FlattenConfig
        Section ``flatten`` of the run file.
    meridian : (K, 2) or None
        Content of ``flatten.profile``: r, z in mm.

    Raises
    ------
    DataError
        For surfaces that cannot lie flat and textures without a pattern.
    StageError
        If nothing of a surface is left.
    """
    return FlattenedPair(
        flatten_mesh(reference, config, meridian), flatten_mesh(deformed, config, meridian)
    )


def flatten_mesh(
    mesh: TexturedMesh, config: FlattenConfig, meridian: Floats | None = None
) -> FlattenedSurface:
    """Make the calibrated image of one mesh.

    Parameters
    ----------
    mesh : TexturedMesh
        mm.
    config : FlattenConfig
        Section ``flatten`` of the run file.
    meridian : (K, 2) or None
        Content of ``flatten.profile``: r, z in mm.

    Raises
    ------
    DataError
        For a surface that cannot lie flat or a texture without a pattern.
    StageError
        If nothing of the surface is left.
    """
    piece = cut_piece(mesh.vertices, mesh.faces, name=mesh.name)
    flattening, why = _lay_flat(mesh, piece, config, meridian)
    plane = place(mesh.vertices, piece, flattening)
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


def _lay_flat(
    mesh: TexturedMesh, piece: Piece, config: FlattenConfig, meridian: Floats | None
) -> tuple[Flattening, str]:
    """Flatten one piece, in its own unit, and say how well it went."""
    return lay_flat(
        mesh.vertices[piece.vertex_ids],
        piece.faces,
        name=mesh.name,
        method=config.method,
        axis=None if config.axis is None else np.array(config.axis),
        centre=None if config.centre is None else np.array(config.centre),
        projection=config.projection or "equidistant",
        meridian=meridian,
        most_lost=MOST_LOST,
        most_anisotropy=MOST_ANISOTROPY,
        most_reduced=MOST_REDUCED,
    )


def _worst(distortion: Distortion, px_per_mm: float) -> str:
    """Say how much coarser the worst hundredth of the surface is shown."""
    worst = weighted_quantile(local_scale(distortion), distortion.area, 0.01)
    return f"1 % of the surface has less than {worst:.3g} px/mm ({worst / px_per_mm:.0%})"
