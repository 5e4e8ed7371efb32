"""Two pictures that differ too much for correlation, bridged by a morph sequence in nine steps."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from shapemorph.config import RunConfig
from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.laws import LawInputs
from shapemorph.core.matching import Matches, Warp
from shapemorph.methods.sequence_turn import Turn, turn_between
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.picture_match import correlate_originals, match_pictures
from shapemorph.pipeline.sequence import make_sequence

if TYPE_CHECKING:
    from shapemorph.methods.coarse_grid import Middle

NEAR_PLANE = 3.0  # px: pairs so near the plane through dv are kept in any case
STIFFNESS = 1e-3  # of the warp through points that whole pixels have found
ENOUGH = 20  # points carried to both pictures
SPARSE = 2  # times the spacing of the points: so the middle is searched for a start of them
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class Bridged:
    """How one picture was followed into another over synthetic ones.

    Attributes
    ----------
    grid : CorrelationGrid
        First picture -> second.
    matches : Matches
    warps : two Warp
        Forward and backward, through the pairs that the cameras allow.
    start : Warp
        First picture -> second, through the points of the middle grid that were carried to
        both: where the last match begins.
    middle : Middle
        The regular grid on the picture before the middle, and what was found in the next one.
    carried : (P, 2, 2) float64
        These points in the first and in the second picture, without those that were lost.
    """

    grid: CorrelationGrid
    matches: Matches
    warps: tuple[Warp, Warp]
    start: Warp
    middle: "Middle"
    carried: Floats


def bridge_pictures(
    first: GreyImage, second: GreyImage, config: RunConfig, clock: Clock, *, views: bool
) -> Bridged:
    """Follow points from one picture into another by image-morphing.

    The masks are given (step 1). Features are matched (2), their disparities (3) become smooth
    warps both ways (4). Synthetic pictures (5, 6) bridge the gap: a grid on the one in the
    middle is searched in the next by whole pixels (7) and carried outwards to both originals
    (8), which are matched with each other from there (9); synthetic pictures never enter that
    last match. Where points are carried as the pictures were moved, those between the middle
    and the originals are not needed, and not drawn.

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
    pictures, turn = clock.run("morph", lambda: _pictures(first, second, warps, config))
    middle, carried = clock.run("carry", lambda: _carried(pictures, warps, turn, config))
    start = _through(carried, first.shape)
    grid = clock.run("correlate", lambda: correlate_originals(first, second, start, config))
    return Bridged(grid, matches, warps, start, middle, carried)


def _pictures(
    first: GreyImage, second: GreyImage, warps: tuple[Warp, Warp], config: RunConfig
) -> tuple[Sequence[GreyImage], Turn]:
    """Draw the whole way where it is searched picture by picture, else only its middle.

    With the turn that the pictures were turned by.
    """
    from shapemorph.methods.morph_sequence import morph_sequence
    from shapemorph.methods.sequence_steps import points_of

    if config.correlate.mode == "paper":
        sequence = make_sequence(first, second, warps, config.morph)
        return sequence.pictures, sequence.turn
    turn = turn_between(points_of(first), warps[0])
    images = 0 if config.morph.images == 0 else 2
    return (first, *morph_sequence(first, second, *warps, images=images, turn=turn), second), turn


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


def _carried(
    pictures: Sequence[GreyImage], warps: tuple[Warp, Warp], turn: Turn, config: RunConfig
) -> tuple["Middle", Floats]:
    """Search the middle grid in the next picture, and carry both outwards."""
    from shapemorph.methods.coarse_grid import carry_by_search, carry_by_warp, search_middle
    from shapemorph.methods.subset_choice import settled_sizes

    given, paper = config.correlate, config.correlate.mode == "paper"
    size, spacing = settled_sizes(pictures[0], subset_size=given.subset_size, spacing=given.spacing)
    middle = search_middle(
        pictures,
        search=given.search,
        subset_size=size,
        spacing=spacing if paper else SPARSE * spacing,
        least_zncc=given.min_zncc,
    )
    if paper:
        carried = carry_by_search(pictures, middle)
    else:
        carried = carry_by_warp(middle, warps, images=len(pictures) - 2, turn=turn)
    if len(carried) < ENOUGH:
        raise StageError(
            f"expected {ENOUGH} or more points of the middle of the morph sequence in both "
            f"pictures, got {len(carried)}: raise morph.images or correlate.search"
        )
    return middle, carried


def _through(carried: Floats, shape: tuple[int, int]) -> Warp:
    source, target = carried[:, 0], carried[:, 1]
    area = float(np.prod(np.ptp(source, axis=0)))
    spacing = max(4.0, 3.0 * float(np.sqrt(area / len(source))))
    return _fitted(source, target, shape, spacing, STIFFNESS)
