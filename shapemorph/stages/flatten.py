"""Stage `flatten`: textured meshes to calibrated images."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shapemorph.config import FlattenConfig
from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import DataError, StageError
from shapemorph.core.flattened import Distortion, FlattenedPair, FlattenedSurface
from shapemorph.core.image import CalibratedImage
from shapemorph.core.mesh import TexturedMesh
from shapemorph.methods.calibrating import calibrate
from shapemorph.methods.charting import chart_at_scale
from shapemorph.methods.charts.atlas import (
    ENOUGH_GOOD,
    Atlas,
    Lay,
    chart_surface,
    cut_patch,
    good_area,
    lay_piece,
)
from shapemorph.methods.charts.correspondence import Counterparts
from shapemorph.methods.charts.mosaic import PAGE_GAP, Page, bind, with_pages
from shapemorph.methods.distortion import chart_distortion, local_scale, weighted_quantile
from shapemorph.methods.gluing import face_areas
from shapemorph.methods.mirroring import mirror_image
from shapemorph.methods.parametrize.automatic import Flattening
from shapemorph.methods.parametrize.choice import PROJECTIONS, lay_flat
from shapemorph.methods.parametrize.disk import cut_pieces
from shapemorph.methods.scale import choose_scale, measure_pattern
from shapemorph.methods.second_tries import are_mirrored
from shapemorph.methods.threads import run_at_once

logger = logging.getLogger(__name__)

MOST_LOST = 0.005  # share of the area that a sound map may flip or overlap
MOST_ANISOTROPY = 2.0  # ratio of stretches that 99 % of a sound map's area stays below
MOST_CHARTS = 12  # of a component, when their number is free
MORE_CHARTS = 3  # that the reference may get so that those of the deformed shape lie well
TRIAL = FlattenConfig(method="bff")  # quick: by it the number of charts is chosen
RATIO = 0.85  # of the best to the second best descriptor, for pairs between charts
CONVINCING_PAIRS = 20  # of which twice as many must match for a picture to be mirrored
MOST_REDUCED = 4.0  # a sound map shows 99 % of the area at a quarter of the median scale or more


def flatten(
    reference: TexturedMesh,
    deformed: TexturedMesh,
    config: FlattenConfig,
    meridian: Floats | None = None,
) -> FlattenedPair:
    """Flatten both shapes, each at its own scale.

    Where one is a mesh through a cloud of points, which has no outer side, the deformed
    picture is mirrored if that is what makes the two match.

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
    first, second = run_at_once(
        lambda mesh: flatten_mesh(mesh, config, meridian), (reference, deformed)
    )
    if first.calibrated.chart.page_count == second.calibrated.chart.page_count == 1:
        if not (reference.sided and deformed.sided):
            second = _from_the_same_side(first, second)
        return FlattenedPair(first, second)
    return _flatten_by_correspondence(
        (reference, first), (deformed, second), config, _lay(deformed, config, meridian)
    )


def flatten_mesh(
    mesh: TexturedMesh, config: FlattenConfig, meridian: Floats | None = None, *, least: int = 1
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
    least : int
        Charts of its largest component, where their number is free.

    Raises
    ------
    DataError
        For a surface that cannot lie flat or a texture without a pattern.
    StageError
        If nothing of the surface is left.
    """
    atlas = _atlas(mesh, config, _lay(mesh, config, meridian), least)
    piece, plane, _ = bind(atlas.pages, gap=0.0)
    pattern = measure_pattern(mesh, piece, plane, max_megapixels=config.max_megapixels)
    px_per_mm, scale_reason = choose_scale(
        pattern,
        plane,
        speckle_px=config.speckle_px,
        max_megapixels=config.max_megapixels,
        px_per_mm=config.px_per_mm,
    )
    image, distortion = _picture(mesh, atlas.pages, px_per_mm)
    reason = f"{atlas.reason}; {scale_reason}; {_worst(distortion, px_per_mm)}"
    logger.info("%s: %s", mesh.name, reason)
    return FlattenedSurface(
        calibrated=image,
        distortion=distortion,
        method=_name(atlas.methods),
        reason=reason,
        speckle_px=pattern.typical_chart_mm * px_per_mm,
        speckle_mm=pattern.typical_mm,
        texels_per_px=pattern.texels_per_mm / px_per_mm,
    )


def _atlas(mesh: TexturedMesh, config: FlattenConfig, lay: Lay, least: int) -> Atlas:
    """Lay a mesh flat in one piece where the method has its own, else in charts."""
    if config.method in PROJECTIONS:
        piece, *others = cut_pieces(mesh.vertices, mesh.faces, name=mesh.name)
        page, flattening, why = lay_piece(mesh, piece, np.ones(len(piece.faces), bool), lay)
        if others:
            why += f"; only the largest of {1 + len(others)} connected pieces is shown"
        return Atlas([page], (flattening.method,), why)
    most = max(MOST_CHARTS, least)
    if config.charts is not None:
        least = most = config.charts
    return chart_surface(mesh, lay, trial=_lay(mesh, TRIAL, None), least=least, most=most)


def _picture(
    mesh: TexturedMesh, pages: Sequence[Page], px_per_mm: float
) -> tuple[CalibratedImage, Distortion]:
    """Make one calibrated image of all pages."""
    piece, plane, lefts = bind(pages, gap=PAGE_GAP / px_per_mm)
    chart = chart_at_scale(piece, plane, px_per_mm=px_per_mm)
    if len(pages) > 1:
        chart = with_pages(chart, pages, lefts)
    image, overlap = calibrate(mesh, chart)
    if overlap > MOST_LOST:
        logger.warning("%s: %.1f %% of the flattened image overlaps", mesh.name, 100 * overlap)
    return image, chart_distortion(mesh.vertices, chart)


def _from_the_same_side(first: FlattenedSurface, second: FlattenedSurface) -> FlattenedSurface:
    """Show the second from behind where the first shows its mirror image."""
    images = first.calibrated.image, second.calibrated.image
    if not are_mirrored(*images, ratio=RATIO, needed=CONVINCING_PAIRS):
        return second
    return replace(
        second,
        calibrated=mirror_image(second.calibrated),
        reason=f"{second.reason}; mirrored to show the side that the reference shows",
    )


def _flatten_by_correspondence(
    reference: tuple[TexturedMesh, FlattenedSurface],
    deformed: tuple[TexturedMesh, FlattenedSurface],
    config: FlattenConfig,
    lay: Lay,
) -> FlattenedPair:
    """Give the deformed shape a chart for each of the reference: what shows the same material.

    Where one of them cannot lie flat well, the reference is split further: into charts whose
    counterparts follow from the pairs that are known, if they lie well then.
    """
    mesh, first = reference
    least = first.calibrated.chart.page_count
    most = least + (MORE_CHARTS if config.charts is None else 0)
    counterparts = Counterparts(deformed[0], deformed[1].calibrated, ratio=RATIO)
    counterparts.learn(first.calibrated)
    best: tuple[FlattenedSurface, _Laid] | None = None
    reasons = []
    for count in range(least, most + 1):
        if count > least:
            first = flatten_mesh(mesh, config, least=count)
        try:
            laid = _lay_counterparts(counterparts, mesh, first)
            if count > least and laid.good < ENOUGH_GOOD:
                counterparts.learn(first.calibrated)
                laid = _lay_counterparts(counterparts, mesh, first)
        except (DataError, StageError) as error:
            reasons.append(str(error))
            continue
        if best is None or laid.good > best[1].good:
            best = first, laid
        if laid.good >= ENOUGH_GOOD:
            break
    if best is None:
        raise StageError(
            f"{deformed[0].name} could not be laid flat chart by chart: "
            f"{'; '.join(dict.fromkeys(reasons))}"
        )
    settled = _settle(*deformed, best[1], lay)
    pairs = counterparts.pairs(best[0].calibrated, settled.calibrated)
    return FlattenedPair(best[0], settled, pairs)


@dataclass(frozen=True, slots=True, eq=False)
class _Laid:
    """Boundary-first maps of some pieces, and the share of their area that lies well."""

    pages: list[Page]
    flattenings: list[Flattening]
    good: float


def _lay_counterparts(
    counterparts: Counterparts, reference: TexturedMesh, first: FlattenedSurface
) -> _Laid:
    """Lay flat, for a trial, what corresponds to each chart of the reference."""
    mesh = counterparts.mesh
    trial = _lay(mesh, TRIAL, None)
    pieces = [cut_patch(mesh, patch) for patch in counterparts.patches(reference, first.calibrated)]
    laid = [lay_piece(mesh, piece, home, trial) for piece, home in pieces]
    pages = [page for page, _, _ in laid]
    areas = [face_areas(mesh.vertices, mesh.faces[page.piece.face_ids]).sum() for page in pages]
    good = sum(good_area(mesh, page) for page in pages) / sum(areas)
    return _Laid(pages, [flattening for _, flattening, _ in laid], good)


def _settle(
    mesh: TexturedMesh, before: FlattenedSurface, trial: _Laid, lay: Lay
) -> FlattenedSurface:
    """Make the calibrated image of some pieces by the method that is asked for."""
    trials = zip(trial.pages, trial.flattenings, strict=True)
    laid = [lay_piece(mesh, made[0].piece, made[0].home, lay, made) for made in trials]
    px_per_mm = before.calibrated.chart.px_per_mm
    image, distortion = _picture(mesh, [page for page, _, _ in laid], px_per_mm)
    why = "; ".join(why for _, _, why in laid)
    return replace(
        before,
        calibrated=image,
        distortion=distortion,
        method=_name([flattening.method for _, flattening, _ in laid]),
        reason=f"{len(laid)} charts by their matches; {why}; {_worst(distortion, px_per_mm)}",
    )


def _name(methods: Sequence[str]) -> str:
    return ", ".join(dict.fromkeys(methods))


def _lay(mesh: TexturedMesh, config: FlattenConfig, meridian: Floats | None) -> Lay:
    """Give the function that flattens a piece in its own unit and says how well it went."""

    def lay(
        vertices: Floats, faces: Ints, made: Flattening | None = None
    ) -> tuple[Flattening, str]:
        return lay_flat(
            vertices,
            faces,
            name=mesh.name,
            method=config.method,
            axis=None if config.axis is None else np.array(config.axis),
            centre=None if config.centre is None else np.array(config.centre),
            projection=config.projection or "equidistant",
            meridian=meridian,
            most_lost=MOST_LOST,
            most_anisotropy=MOST_ANISOTROPY,
            most_reduced=MOST_REDUCED,
            made=made,
        )

    return lay


def _worst(distortion: Distortion, px_per_mm: float) -> str:
    """Say how much coarser the worst hundredth of the surface is shown."""
    worst = weighted_quantile(local_scale(distortion), distortion.area, 0.01)
    return f"1 % of the surface has less than {worst:.3g} px/mm ({worst / px_per_mm:.0%})"
