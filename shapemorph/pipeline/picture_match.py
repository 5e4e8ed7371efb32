"""From two plain pictures to the grid that follows one into the other."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from shapemorph.config import RunConfig
from shapemorph.core.errors import ConfigError, StageError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.laws import LawInputs
from shapemorph.core.matching import Matches, Warp
from shapemorph.core.morphed import Morphed
from shapemorph.core.status import PointStatus
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.law_inputs import read_law_inputs

if TYPE_CHECKING:
    from shapemorph.methods.near_start import NearStart
    from shapemorph.methods.subset_dic import SubsetSettings

ENOUGH = 0.9  # of the points that may be expected: fewer, and features are matched
NEAR_ENOUGH = 0.02  # px: to this the subsets of a near start settle
BENT, MANY_BENT = 0.05, 0.1  # px of bias; share of the points for which it is worth a try
ALIKE = 0.97  # median ZNCC from which on neither picture is asked whether it is out of focus
GENTLE = 0.1  # change of the gradient that subsets follow without a morphed picture
TRIED = 2000  # points of a picture that are asked for it
log = logging.getLogger(__name__)


def picture_law_inputs(config: RunConfig) -> LawInputs:
    """Read what the law of two plain pictures needs.

    Raises
    ------
    ConfigError
        If it needs meshes.
    """
    morph = config.morph
    if morph.law == "fe" or (morph.law == "landmarks" and morph.dots is None):
        raise ConfigError(
            f"law {morph.law} needs two textured meshes, got two pictures: choose morph.law=warp, "
            "polynomial or identity, or landmarks with morph.dots"
        )
    return read_law_inputs(morph, (morph.law,), lambda _: 1.0, lambda: None)


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """How one picture was followed into another.

    Attributes
    ----------
    grid : CorrelationGrid
    matches : Matches or None
        None where no features had to be matched.
    """

    grid: CorrelationGrid
    matches: Matches | None


def follow_pictures(
    left: GreyImage,
    right: GreyImage,
    config: RunConfig,
    inputs: LawInputs,
    clock: Clock,
    far: RunConfig | None = None,
) -> Followed:
    """Follow the points of one picture into another, with features only where it takes them.

    Pictures that lie near each other start from an affine map; if that finds too few
    points, or a law is asked for, features are matched, and the better field is kept.
    What takes features is correlated as `far` says, if it is given.

    Raises
    ------
    StageError
        If nothing was found.
    """
    if config.correlate.seeds == "propagate":
        still = morph_by_warp(left, right, _unmoved(left))
        return Followed(
            clock.run("correlate", lambda: correlate_pictures(left, right, still, config)), None
        )
    near = None
    if config.morph.law == "warp":
        start = clock.run("start", lambda: _near_start(left, right, config))
        if start is not None:
            near = clock.run("correlate", lambda: _correlate_near(left, right, start, config))
    if near is not None and near.ok_count >= ENOUGH * points_on(left, near.spacing):
        return Followed(near, None)
    try:
        matches = clock.run("match", lambda: match_pictures(left, right, inputs, config))
        morphed = clock.run("morph", lambda: morph_by_law(left, right, matches, inputs, config))
        found = clock.run(
            "correlate", lambda: correlate_pictures(left, right, morphed, far or config)
        )
    except StageError:
        if near is None:
            raise
        return Followed(near, None)
    if near is not None and near.ok_count > found.ok_count:
        return Followed(near, None)
    return Followed(found, matches)


def _unmoved(picture: GreyImage) -> Warp:
    from shapemorph.methods.laws.identity import identity_warp

    return identity_warp(picture.shape)


def points_on(picture: GreyImage, spacing: int) -> int:
    """Count the grid points on the mask of a picture."""
    return int(np.count_nonzero(picture.mask[::spacing, ::spacing]))


def correlate_from(
    left: GreyImage, right: GreyImage, warps: Sequence[Warp], config: RunConfig
) -> CorrelationGrid | None:
    """Follow points from where the likeliest of some warps says; None if none is found."""
    from shapemorph.methods.near_start import likeliest_start, start_from
    from shapemorph.methods.threads import kernel_threads

    if len(warps) == 1 and not _is_gentle(warps[0], left):
        return _correlate_morphed(left, right, warps[0], config)
    settings, limits = _near_settings(left, config), config.correlate
    start = start_from(warps[0], left, right, settings=settings)
    with kernel_threads(limits.threads):
        start = likeliest_start(
            start, warps, left.mask, settings=settings, min_zncc=limits.min_zncc
        )
    return _correlate_as_they_are(left, right, start, config)


def _correlate_morphed(
    left: GreyImage, right: GreyImage, warp: Warp, config: RunConfig
) -> CorrelationGrid | None:
    """Follow points into a morphed picture; None if none is found."""
    morphed = morph_by_warp(left, right, warp)
    return _if_found(lambda: correlate_pictures(left, right, morphed, config))


def correlate_originals(
    left: GreyImage, right: GreyImage, warp: Warp, config: RunConfig
) -> CorrelationGrid:
    """Follow points from where a warp says that they are, in the two pictures as they are.

    Nothing is morphed, whatever the warp, so that subsets must follow its bending themselves.
    """
    from shapemorph.methods.near_start import start_from

    as_they_are = config.correlate.model_copy(update={"refinements": 0})
    config = config.model_copy(update={"correlate": as_they_are})
    start = start_from(warp, left, right, settings=_near_settings(left, config))
    return correlate_pictures(left, right, Morphed(right, _unmoved(right)), config, start)


def _correlate_near(
    left: GreyImage, right: GreyImage, start: "NearStart", config: RunConfig
) -> CorrelationGrid | None:
    """Follow points from a near start; None if none is found."""
    if not _is_gentle(start.warp, left):
        return _correlate_morphed(left, right, start.warp, config)
    return _correlate_as_they_are(left, right, start, config)


def _correlate_as_they_are(
    left: GreyImage, right: GreyImage, start: "NearStart", config: RunConfig
) -> CorrelationGrid | None:
    """Follow points in a picture that is not morphed beforehand; None if none is found."""
    unmoved = Morphed(right, _unmoved(right))
    found = _if_found(lambda: correlate_pictures(left, right, unmoved, config, start))
    icgn = config.correlate.mode == "icgn"
    if icgn and found is not None and _one_is_softer(left, right, found):
        return _correlate_morphed(left, right, start.warp, config)
    if found is None or (finer := _with_finer_subset(found, left, config)) is None:
        return found
    again = _if_found(lambda: correlate_pictures(left, right, unmoved, finer, start))
    return found if again is None or again.ok_count < ENOUGH * found.ok_count else again


def _one_is_softer(left: GreyImage, right: GreyImage, found: CorrelationGrid) -> bool:
    """Tell if two pictures agree so poorly because one of them is out of focus."""
    if left.shape != right.shape or np.nanmedian(found.zncc) > ALIKE:
        return False
    from shapemorph.methods.sharpness import missing_blur

    return bool(missing_blur(left, right))


def _with_finer_subset(
    found: CorrelationGrid, left: GreyImage, config: RunConfig
) -> RunConfig | None:
    """Choose a smaller subset where many bend more than they follow; None where few do."""
    from shapemorph.methods.subset_choice import finest_subset

    given = config.correlate
    if given.subset_size is not None or found.bias_px is None:
        return None
    off = np.abs(found.bias_px[found.status == PointStatus.OK]).max(axis=-1)
    size = finest_subset(left, order=given.order)
    if (off > BENT).mean() < MANY_BENT or size >= found.subset_size:
        return None
    log.info(
        "the field bends within subsets of %d px: once more with %d px", found.subset_size, size
    )
    sizes = {"subset_size": size, "spacing": found.spacing}
    return config.model_copy(update={"correlate": given.model_copy(update=sizes)})


def _if_found(correlate: Callable[[], CorrelationGrid]) -> CorrelationGrid | None:
    try:
        return correlate()
    except StageError as error:
        log.info("nothing from a near start: %s", error)
        return None


def _is_gentle(warp: Warp, picture: GreyImage) -> bool:
    """Tell if a warp stretches and turns so little that subsets need no morphed picture."""
    from shapemorph.methods.densify import grid_points
    from shapemorph.methods.warping import warp_points

    step = max(1.0, float(np.sqrt(picture.mask.sum() / TRIED)))
    _, slope = warp_points(warp, grid_points(picture.mask, step))
    return bool(np.nanmax(np.abs(slope - np.eye(2)), initial=0.0) < GENTLE)


def _near_start(left: GreyImage, right: GreyImage, config: RunConfig) -> "NearStart | None":
    from shapemorph.methods.near_start import near_start
    from shapemorph.methods.subset_choice import choose_subset
    from shapemorph.methods.threads import kernel_threads

    def speckle() -> float:
        return choose_subset(left, subset_size=None, spacing=None).speckle_px

    settings, least = _near_settings(left, config), config.correlate.min_zncc
    with kernel_threads(config.correlate.threads):
        return near_start(left, right, speckle=speckle, settings=settings, min_zncc=least)


def _near_settings(left: GreyImage, config: RunConfig) -> "SubsetSettings":
    """Settle how the subsets of a start are matched."""
    from shapemorph.methods.subset_choice import settled_sizes
    from shapemorph.methods.subset_dic import SubsetSettings

    given = config.correlate
    size, _spacing = settled_sizes(left, subset_size=given.subset_size, spacing=given.spacing)
    radius = size // 2
    return SubsetSettings(
        radius=radius,
        order=1,
        tolerance=NEAR_ENOUGH,
        max_iterations=given.max_iterations,
        min_inside=given.min_inside,
        max_drift=float(radius),
        degree=given.degree,
    )


def match_pictures(
    left: GreyImage, right: GreyImage, inputs: LawInputs, config: RunConfig
) -> Matches:
    """Match features, else begin with the marks of the law; errors as the stage raises them.

    The ground beside a specimen takes no part: its noise is no pattern.
    """
    from shapemorph.methods.bare_ground import without_ground
    from shapemorph.stages.match import match

    return match(without_ground(left), without_ground(right), config.match, inputs.dots)


def morph_by_law(
    left: GreyImage, right: GreyImage, matches: Matches, inputs: LawInputs, config: RunConfig
) -> Morphed:
    """Bring the right picture close to the left one as the configured law says."""
    from shapemorph.stages.morph import morph_pictures

    return morph_pictures(left, right, matches, inputs, config.morph)


def morph_by_warp(left: GreyImage, right: GreyImage, warp: Warp) -> Morphed:
    """Bring the right picture close to the left one through a known warp."""
    from shapemorph.methods.morphing import morph_image

    return Morphed(morph_image(right, warp, left.shape), warp)


def correlate_pictures(
    left: GreyImage,
    right: GreyImage,
    morphed: Morphed,
    config: RunConfig,
    start: "NearStart | None" = None,
) -> CorrelationGrid:
    """Follow the points of the left picture into the right one."""
    from shapemorph.stages.correlate import correlate

    def remorph(warp: Warp) -> GreyImage:
        return morph_by_warp(left, right, warp).image

    return correlate(left, remorph, morphed, config.correlate, None, start)
