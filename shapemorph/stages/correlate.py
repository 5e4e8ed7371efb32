"""Stage `correlate`: subset DIC between the reference and the morphed picture."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from shapemorph.config import CorrelateConfig
from shapemorph.core.arrays import Bools, Codes, Floats
from shapemorph.core.errors import StageError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.core.morphed import Morphed
from shapemorph.core.status import PointStatus, count_statuses
from shapemorph.methods.alike_pictures import made_alike
from shapemorph.methods.correlation_noise import displacement_covariance
from shapemorph.methods.cut_subsets import cut_noise, inside_share
from shapemorph.methods.grid_correlation import GridMatches, Limits, correlate_grid
from shapemorph.methods.matched_subsets import MatchedSubsets
from shapemorph.methods.near_start import NearStart
from shapemorph.methods.paper_dic import SearchSettings, correlate_like_paper
from shapemorph.methods.propagation import correlate_from_seeds
from shapemorph.methods.rest_motion import unfollowed_motion
from shapemorph.methods.returned_matches import lost_on_return
from shapemorph.methods.seen_bends import seen_bends
from shapemorph.methods.spline_pictures import (
    DeformedPicture,
    ReferencePicture,
    detail_length,
    prepare_deformed,
    prepare_reference,
)
from shapemorph.methods.steady_slopes import stands_out, steady_slopes
from shapemorph.methods.subset_choice import settled_sizes
from shapemorph.methods.subset_dic import PointGrid, SubsetSettings, affine_starts, grid_points
from shapemorph.methods.systematic import shape_bias, systematic_error
from shapemorph.methods.threads import kernel_threads
from shapemorph.methods.warp_renewal import SMOOTHING, FoundGrid, renew_warp
from shapemorph.methods.warping import warp_points

OUTLIER_FLOOR = 0.15  # px; a residual may always differ so much from its neighbours
FOLLOWED, MISSED = 99.0, 2.0  # percentile of the points; times the random error
FINE = 1e-3  # px: a random error below it is taken for this
LEAST_UNLIKE = 1e-6  # 1 - ZNCC^2 of a match without any noise


def correlate(  # noqa: PLR0913 - the last two are known of some pairs only
    reference: GreyImage,
    remorph: Callable[[Warp], GreyImage],
    morphed: Morphed,
    config: CorrelateConfig,
    region: Bools | None,
    start: NearStart | None = None,
    *,
    grain: float = 0.0,
) -> CorrelationGrid:
    """Follow a regular grid of points from the reference into the deformed picture.

    The reference is matched with the morphed picture, from no motion at all; then the
    warp is fitted to what was found and the deformed picture is morphed again, so that
    the last matches see hardly any motion, and no curvature of it, that the shape
    function could not follow. With a `start` that is left out where the shape function
    follows the field already. Subset and spacing suit the reference as it is: what is done
    to make both sides alike depends on the first morph, which may be crude.

    Parameters
    ----------
    reference : GreyImage
    remorph : callable
        Morphs the deformed picture through another warp.
    morphed : Morphed
    config : CorrelateConfig
        Section ``correlate`` of the run file.
    region : (H, W) bool or None
        Part of the reference that is measured; None for all of its mask.
    start : NearStart or None
        Where the first search begins in `morphed`, which then is the deformed picture
        itself; None for no motion.
    grain : float
        What noisy meshes do to matches: standard deviation of a component times the width
        of the subset, px^2 of the reference. It bends no renewed warp.

    Raises
    ------
    StageError
        If no point has a value.
    """
    given = morphed.image
    size, spacing = settled_sizes(reference, subset_size=config.subset_size, spacing=config.spacing)
    if config.mode == "icgn":
        reference, remorph, morphed = made_alike(reference, remorph, morphed, start)
    settings = _settings(config, size // 2)
    measured = reference.mask if region is None else reference.mask & region
    grid = grid_points(measured, spacing=spacing)
    if not grid.inside.any():
        raise StageError(
            f"expected points every {spacing} px inside mask and region, got none: lower "
            "correlate.spacing or enlarge inputs.region"
        )
    with kernel_threads(config.threads):
        if start is None:
            source = prepare_reference(
                reference, allowed=region, pad=settings.pad, degree=settings.degree
            )
            starts = None
        else:
            source, starts = start.source, _starts_through(start.warp, grid)
        target = _target(morphed.image, given, source, settings, start)
        detail, seconds = detail_length(source), 0.0
        for renewal in range(config.refinements + 1):
            found = _matcher(config, settings, morphed.image, starts)(source, target, grid)
            seconds += found.seconds
            share = inside_share(source, target, grid, found, radius=settings.radius)
            tried = _Tried(source, target, grid, found, share)
            rough = _rough_noise(found, detail, settings)
            noise = cut_noise(share) * rough
            if renewal == config.refinements or (
                starts is not None and _follows(found, noise, grid.spacing, settings)
            ):
                break
            doubt = cut_noise(share) * np.hypot(rough, grain / size)
            morphed = _renew(morphed.warp, remorph, tried, settings, doubt)
            target = prepare_deformed(morphed.image, pad=source.pad, degree=settings.degree)
            starts = None
        found = _returning(reference, morphed.image, grid, found, noise, settings)
        if not found.ok.any():
            raise StageError(_nothing(found.status))
        covariance = displacement_covariance(
            source, target, grid.points, found.warps, found.ok, settings=settings
        )
        if settings.order == 1 and config.mode == "icgn":
            found, covariance = steady_slopes(
                source, target, grid, found, covariance, settings=settings
            )
    found = replace(found, seconds=seconds)
    composed = _compose(morphed.warp, grid, found, covariance, settings, config.max_sigma or np.inf)
    rest = unfollowed_motion(
        source, target, grid.points, found.warps, found.ok, radius=settings.radius
    )
    bias = systematic_error(source, found, rest, composed, order=settings.order)
    return replace(composed, bias_px=bias, smoothing=SMOOTHING[0] if renewal else 0.0)


def _target(
    image: GreyImage,
    given: GreyImage,
    source: ReferencePicture,
    settings: SubsetSettings,
    start: NearStart | None,
) -> DeformedPicture:
    """Prepare the picture that is searched, unless a start has prepared what was given."""
    if start is not None and image is given:
        return start.target
    return prepare_deformed(image, pad=source.pad, degree=settings.degree)


def _returning(
    reference: GreyImage,
    deformed: GreyImage,
    grid: PointGrid,
    found: GridMatches,
    noise: Floats,
    settings: SubsetSettings,
) -> GridMatches:
    """Take the matches in doubt that do not lead back to their start for what they are."""

    def backwards() -> tuple[ReferencePicture, DeformedPicture]:
        pad, degree = settings.pad, settings.degree
        return (
            prepare_reference(deformed, allowed=None, pad=pad, degree=degree),
            prepare_deformed(reference, pad=pad, degree=degree),
        )

    lost = lost_on_return(backwards, grid, found, noise, settings=settings)
    return replace(found, status=np.where(lost, np.uint8(PointStatus.OUTLIER), found.status))


Matcher = Callable[[ReferencePicture, DeformedPicture, PointGrid], GridMatches]


def _matcher(
    config: CorrelateConfig, settings: SubsetSettings, image: GreyImage, starts: Floats | None
) -> Matcher:
    """Way to match the grid with the morphed picture that is configured."""
    limits = Limits(config.min_zncc, OUTLIER_FLOOR)
    if config.mode == "icgn" and config.seeds == "warp":
        return partial(correlate_grid, settings=settings, limits=limits, starts=starts)
    sought = SearchSettings(settings, limits, config.search)
    if config.mode == "paper":
        matcher = partial(correlate_like_paper, settings=sought, starts=starts)
    else:
        matcher = partial(correlate_from_seeds, settings=sought)
    return lambda source, target, grid: matcher(source, target, image, grid)


def _starts_through(warp: Warp, grid: PointGrid) -> Floats:
    """(N, 12) starts of the points inside, as a warp says."""
    at = grid.points[grid.inside]
    return affine_starts(at, *warp_points(warp, at.astype(np.float64)))


def _follows(found: GridMatches, noise: Floats, spacing: int, settings: SubsetSettings) -> bool:
    """Tell if what the shape function misses of the field is lost in the random error."""
    bias = shape_bias(
        found.position, found.ok, spacing=spacing, radius=settings.radius, order=settings.order
    )
    share = np.abs(bias).max(axis=-1) / np.maximum(noise, FINE)
    known = np.isfinite(share)
    return bool(known.any() and np.percentile(share[known], FOLLOWED) < MISSED)


def _settings(config: CorrelateConfig, radius: int) -> SubsetSettings:
    return SubsetSettings(
        radius=radius,
        order=config.order,
        tolerance=config.tolerance,
        max_iterations=config.max_iterations,
        min_inside=config.min_inside,
        max_drift=float(radius),
        degree=config.degree,
    )


def _rough_noise(found: GridMatches, detail: float, settings: SubsetSettings) -> Floats:
    """(R, C) random error to be expected from the ZNCC, px; NaN where not OK."""
    width = 2 * settings.radius + 1
    unlike = np.maximum(1.0 - found.zncc**2, LEAST_UNLIKE)
    return np.where(found.ok, detail * np.sqrt(unlike) / width, np.nan)


@dataclass(frozen=True, slots=True, eq=False)
class _Tried:
    """A grid that was searched, in what, what was found, and which share of each subset counts."""

    source: ReferencePicture
    target: DeformedPicture
    grid: PointGrid
    found: GridMatches
    share: Floats


def _renew(
    warp: Warp,
    remorph: Callable[[Warp], GreyImage],
    tried: _Tried,
    settings: SubsetSettings,
    noise: Floats,
) -> Morphed:
    """Morph again, through the warp that the points have found."""
    grid, found, cut = tried.grid, tried.found, tried.share < 1.0
    deformed, _slope = _through_warp(warp, found.position)
    noise = np.where(np.isfinite(deformed).all(axis=-1), noise, np.nan)
    if not np.isfinite(noise).any():
        raise StageError(_nothing(found.status))
    chosen = found.ok & cut
    pictures = tried.source, tried.target
    subsets = MatchedSubsets.at(pictures, grid.points, found.warps, chosen, settings.radius)
    seen = seen_bends(subsets, chosen, order=settings.order)
    width = 2 * settings.radius + 1
    renewed = renew_warp(
        warp,
        FoundGrid(grid.points, deformed, noise, grid.spacing, seen, ~cut),
        reach=(SMOOTHING[0] * width, SMOOTHING[1] * width),
    )
    return Morphed(remorph(renewed), renewed)


def _through_warp(warp: Warp, position: Floats) -> tuple[Floats, Floats]:
    """(R, C, 2) targets of positions and (R, C, 2, 2) gradients of the warp there."""
    targets, gradient = warp_points(warp, position.reshape(-1, 2))
    return targets.reshape(position.shape), gradient.reshape(*position.shape, 2)


def _compose(
    warp: Warp,
    grid: PointGrid,
    found: GridMatches,
    covariance: Floats,
    settings: SubsetSettings,
    max_sigma: float,
) -> CorrelationGrid:
    """Carry what was found in the morphed picture on into the deformed one."""
    deformed, slope = _through_warp(warp, found.position)
    gradient = slope @ found.gradient
    carried = slope @ covariance @ np.swapaxes(slope, -1, -2)
    finite = np.isfinite(deformed).all(axis=-1) & np.isfinite(carried).all(axis=(-1, -2))
    status = np.where(found.ok & ~finite, np.uint8(PointStatus.LEFT_IMAGE), found.status)
    uncertain = (status == PointStatus.OK) & stands_out(covariance)
    uncertain &= np.diagonal(carried, axis1=-2, axis2=-1).max(axis=-1) > max_sigma**2
    status[uncertain] = PointStatus.LOW_CONTRAST
    lost = status != PointStatus.OK
    if lost.all():
        raise StageError(_nothing(status))
    for values in (deformed, gradient, carried):
        values[lost] = np.nan
    return CorrelationGrid(
        reference_px=grid.points.astype(np.float64),
        deformed_px=deformed,
        gradient=gradient,
        zncc=found.zncc,
        iterations=found.iterations,
        sigma_px=np.sqrt(np.diagonal(carried, axis1=-2, axis2=-1)),
        status=status,
        spacing=grid.spacing,
        subset_size=2 * settings.radius + 1,
        kernel_seconds=found.seconds,
        shared_px2=carried[..., 0, 1],
    )


def _nothing(status: Codes) -> str:
    tried = {k: n for k, n in count_statuses(status).items() if k != PointStatus.OUTSIDE_MASK.name}
    counts = ", ".join(f"{number} {name}" for name, number in tried.items())
    cure = "check that both sides show the same pattern, or raise correlate.subset_size"
    if tried.get(PointStatus.NOT_CONVERGED.name, 0) > sum(tried.values()) / 2:
        cure = (
            "long grain and faint patterns take many iterations: raise correlate.max_iterations "
            "or correlate.tolerance (px); else " + cure
        )
    return f"expected matching points, got none of {sum(tried.values())} ({counts}): {cure}"
