"""Two pictures that differ too much for correlation, bridged by a morph sequence in nine steps."""

import logging
from dataclasses import dataclass

import numpy as np

from shapemorph.config import RunConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.laws import LawInputs
from shapemorph.core.matching import Matches, Warp
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.picture_match import correlate_originals, match_pictures
from shapemorph.pipeline.sequence import MorphSequence, make_sequence

NEAR_PLANE = 3.0  # px: pairs so near the plane through dv are kept in any case
STIFFNESS = 1e-3  # of the warp through points that whole pixels have found
ENOUGH = 20  # points carried to both pictures
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class Bridged:
    """How one picture was followed into another over synthetic ones.

    Attributes
    ----------
    grid : CorrelationGrid
        First picture -> second.
    matches : Matches
    sequence : MorphSequence
    carried : (P, 2, 2) float64
        Points of the middle grid, carried to the first and to the second picture, px.
    """

    grid: CorrelationGrid
    matches: Matches
    sequence: MorphSequence
    carried: Floats


def bridge_pictures(
    first: GreyImage, second: GreyImage, config: RunConfig, clock: Clock, *, views: bool
) -> Bridged:
    """Follow points from one picture into another by image-morphing.

    The masks are given (step 1). Features are matched (2), their disparities (3) become smooth
    warps both ways (4). Synthetic pictures (5, 6) bridge the gap: a grid on the one in the
    middle is searched in the next by whole pixels (7) and carried outwards to both originals
    (8), which are matched with each other from there (9); synthetic pictures never enter that
    last match.

    Parameters
    ----------
    first, second : GreyImage
        Of one size.
    config : RunConfig
        Sections match, morph and correlate.
    clock : Clock
    views : bool
        Both show one state from two cameras side by side: pairs far from the plane through dv
        are outliers.

    Raises
    ------
    StageError
        If too little matches.
    """
    matches = clock.run("match", lambda: match_pictures(first, second, LawInputs(), config))
    warps = clock.run("warp", lambda: _warps(first, second, matches, views=views))
    sequence = clock.run("morph", lambda: make_sequence(first, second, warps, config.morph))
    carried = clock.run("carry", lambda: _carried(sequence, warps, config))
    warp = _through(carried, first.shape)
    grid = clock.run("correlate", lambda: correlate_originals(first, second, warp, config))
    return Bridged(grid, matches, sequence, carried)


def _warps(
    first: GreyImage, second: GreyImage, matches: Matches, *, views: bool
) -> tuple[Warp, Warp]:
    """Forward and backward, without pairs that the two cameras forbid."""
    from shapemorph.methods.plane_outliers import near_plane

    if not views:
        return matches.forward, matches.backward
    kept = near_plane(matches.reference_px, matches.deformed_px, least_px=NEAR_PLANE)
    log.info("%d of %d pairs near the plane through dv", kept.sum(), len(kept))
    if kept.all():
        return matches.forward, matches.backward
    pairs = matches.reference_px[kept], matches.deformed_px[kept]
    return (
        _fitted(*pairs, first.shape, matches.forward.spacing, None),
        _fitted(*pairs[::-1], second.shape, matches.backward.spacing, None),
    )


def _fitted(
    source: Floats,
    target: Floats,
    shape: tuple[int, int],
    spacing: float,
    smoothing: float | None,
) -> Warp:
    from shapemorph.methods.warp_fit import fit_warp

    high = np.array(shape[::-1]) - 1.0
    extent = (-np.full(2, spacing), high + spacing)
    return fit_warp(source, target, extent=extent, spacing=spacing, smoothing=smoothing)


def _carried(sequence: MorphSequence, warps: tuple[Warp, Warp], config: RunConfig) -> Floats:
    """Search the middle grid in the next picture, and carry both outwards."""
    from shapemorph.methods.coarse_grid import carry_by_search, carry_by_warp, search_middle

    middle = search_middle(
        sequence.pictures,
        search=config.correlate.search,
        subset_size=config.correlate.subset_size,
        spacing=config.correlate.spacing,
        least_zncc=config.correlate.min_zncc,
    )
    if config.correlate.mode == "paper":
        carried = carry_by_search(sequence.pictures, middle)
    else:
        images = len(sequence.pictures) - 2
        carried = carry_by_warp(middle, warps, images=images, turn=sequence.turn)
    if len(carried) < ENOUGH:
        raise StageError(
            f"expected {ENOUGH} or more points of the middle of the morph sequence in both "
            f"pictures, got {len(carried)}: raise morph.images or correlate.search"
        )
    return carried


def _through(carried: Floats, shape: tuple[int, int]) -> Warp:
    source, target = carried[:, 0], carried[:, 1]
    area = float(np.prod(np.ptp(source, axis=0)))
    spacing = max(4.0, 3.0 * float(np.sqrt(area / len(source))))
    return _fitted(source, target, shape, spacing, STIFFNESS)
