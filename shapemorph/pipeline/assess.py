"""How well pictures can be correlated, and with what subset."""

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.config import RunConfig, StarConfig
from shapemorph.core.errors import ConfigError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.picture_match import follow_pictures, picture_law_inputs
from shapemorph.pipeline.pictures import (
    PicturePair,
    read_picture_pair,
    read_picture_single,
    with_sizes,
)

LEVELS = 255.0
SMALL_SPECKLE, LARGE_SPECKLE = 3.0, 7.0  # px: beyond them sampling and subsets suffer
LEAST_CONTRAST = 15.0  # levels
MOST_CLIPPED = 0.01
MOST_SIGMA = 0.02  # px
DEFINITIONS = {
    "speckle_px": "diameter of the disk as large as the region of autocorrelation above one half",
    "contrast": "standard deviation of grey, levels of 255",
    "mean_gradient": "mean of |grad grey|, levels/px",
    "sssig": "sum of squared grey gradients over a subset, levels^2, noise taken off",
    "predicted_sigma_px": "sqrt(2) grey noise / sqrt(SSSIG): random error of a displacement",
    "resolution_px": "star: period at which a 12th-order fit of measured / imposed rises to 0.9",
    "mei_px2": "star: metrological efficiency indicator, sigma of displacement x resolution",
}


def assess(
    first: Path, second: Path | None, static: Path | None, config: RunConfig
) -> dict[str, Any]:
    """Measure the community's figures of one picture, of a pair, or of a star pattern.

    Parameters
    ----------
    first : Path
        The reference picture.
    second : Path or None
        Another one: of the same state its difference gives the grey noise.
    static : Path or None
        Star pattern: a further picture of the undeformed state, for its noise.
    config : RunConfig
        `correlate` settings are kept; `assess.star` describes a star pattern.

    Returns
    -------
    dict
        JSON-able; ``definitions`` says what each figure means.

    Raises
    ------
    ConfigError, DataError, StageError
    """
    star = config.assess.star
    if (star is not None or static is not None) and second is None:
        raise ConfigError("a star pattern needs two pictures, reference and deformed; got one")
    if static is not None and star is None:
        raise ConfigError("--static is for a star pattern: set assess.star.periods too")
    if second is None:
        pictures = {"reference": read_picture_single(first, config)}
        noise, source = _own_noise(pictures["reference"])
    else:
        pair = read_picture_pair(first, second, config, None)
        pictures = {"reference": pair.reference, "deformed": pair.deformed}
        noise, source = _noise_of(pair)
    found: dict[str, Any] = {"grey_noise": noise, "grey_noise_source": source}
    found |= {name: _figures(picture, noise, config) for name, picture in pictures.items()}
    if star is not None and second is not None:
        found["star"] = _star(first, second, static, config, star)
    found["advice"] = list(_advice(found["reference"], noise))
    return {**found, "definitions": DEFINITIONS}


def _own_noise(picture: GreyImage) -> tuple[float, str]:
    from shapemorph.methods.subset_choice import grey_noise

    return LEVELS * grey_noise(picture), "second differences of the picture: rather too high"


def _noise_of(pair: PicturePair) -> tuple[float, str]:
    from shapemorph.methods.pair_noise import pair_noise

    noise = LEVELS * pair_noise(pair.reference, pair.deformed)
    if np.isfinite(noise):
        return noise, "difference of both pictures, a little motion allowed"
    own, source = _own_noise(pair.reference)
    return own, f"{source} (the two have moved too far to be subtracted)"


def _figures(picture: GreyImage, noise: float, config: RunConfig) -> dict[str, Any]:
    """Figures of one picture."""
    from shapemorph.methods.picture_quality import picture_quality, predicted_sigma
    from shapemorph.methods.subset_choice import choose_subset

    given = config.correlate
    choice = choose_subset(picture, subset_size=given.subset_size, spacing=given.spacing)
    quality = picture_quality(picture, subset_size=choice.subset_size, noise=noise)
    return {
        "width_px": picture.shape[1],
        "height_px": picture.shape[0],
        "speckle_px": choice.speckle_px,
        **asdict(quality),
        "predicted_sigma_u_px": predicted_sigma(noise, quality.sssig_x),
        "predicted_sigma_v_px": predicted_sigma(noise, quality.sssig_y),
        "predicted_sigma_poor_px": predicted_sigma(noise, quality.sssig_poor),
        "subset_size_px": choice.subset_size,
        "subset_reason": choice.reason,
        "spacing_px": choice.spacing,
        "spacing_reason": "a fourth of the subset: neighbours share most of their pixels"
        if given.spacing is None
        else "as configured",
    }


def _advice(figures: dict[str, Any], noise: float) -> Iterator[str]:
    """Say what to change about the pictures."""
    speckle = figures["speckle_px"]
    if not np.isfinite(speckle):
        yield "no pattern was found: apply a speckle, or check the picture"
        return
    if speckle < SMALL_SPECKLE:
        yield (
            f"speckles of {speckle:.1f} px are sampled too coarsely: make them {SMALL_SPECKLE:g} "
            f"to {LARGE_SPECKLE:g} px, or blur the lens slightly"
        )
    if speckle > LARGE_SPECKLE:
        yield (
            f"speckles of {speckle:.1f} px ask for large subsets: a finer pattern would resolve "
            "more"
        )
    if figures["contrast"] < LEAST_CONTRAST:
        yield f"contrast of {figures['contrast']:.0f} levels is low: more light or a darker pattern"
    if figures["clipped_share"] > MOST_CLIPPED:
        share = figures["clipped_share"]
        yield f"{share:.1%} of the pixels are black or white: change the exposure"
    if figures["predicted_sigma_poor_px"] > MOST_SIGMA:
        yield (
            f"where the pattern is poor, noise of {noise:.1f} levels costs "
            f"{figures['predicted_sigma_poor_px']:.3f} px: larger subsets, or average pictures"
        )


def _star(
    first: Path, second: Path, static: Path | None, config: RunConfig, given: StarConfig
) -> dict[str, Any]:
    """Spatial resolution and metrological efficiency on a star pattern."""
    from shapemorph.methods.star_pattern import Star, spatial_resolution

    pair = read_picture_pair(first, second, config, None)
    height, width = pair.reference.shape
    row = (height - 1) / 2 if given.row is None else given.row
    star = Star(given.amplitude, *given.periods, width, row)
    config = with_sizes(config, pair.reference)
    cut = int(row) % (config.correlate.spacing or 1)
    axis = 0 if given.component == "u" else 1
    grid = _correlated(_below(pair.reference, cut), _below(pair.deformed, cut), config)
    number = int(np.argmin(np.abs(grid.reference_px[:, 0, 1] + cut - int(row))))
    moved = (grid.deformed_px - grid.reference_px)[..., axis]
    resolution = spatial_resolution(
        star, grid.reference_px[number, :, 0], float(grid.reference_px[number, 0, 1] + cut),
        moved[number],
    )  # fmt: skip
    sigma, source = _star_noise(first, static, config, grid, axis)
    return {
        "subset_size_px": grid.subset_size,
        "order": config.correlate.order,
        "resolution_px": resolution,
        "sigma_px": sigma,
        "sigma_source": source,
        "mei_px2": sigma * resolution,
    }


def _star_noise(
    first: Path, static: Path | None, config: RunConfig, grid: CorrelationGrid, axis: int
) -> tuple[float, str]:
    """1 sigma of the displacement."""
    if static is None:
        return float(np.nanmedian(grid.sigma_px[..., axis])), "predicted at each point, median"
    pair = read_picture_pair(first, static, config, None)
    still = _correlated(pair.reference, pair.deformed, config)
    moved = (still.deformed_px - still.reference_px)[..., axis]
    return float(np.nanstd(moved)), "spatial standard deviation in the static picture"


def _correlated(left: GreyImage, right: GreyImage, config: RunConfig) -> CorrelationGrid:
    inputs, clock = picture_law_inputs(config), Clock(lambda _: None)
    return follow_pictures(left, right, config, inputs, clock).grid


def _below(picture: GreyImage, rows: int) -> GreyImage:
    """Cut off the first rows, so that a row of the grid falls on the one that is meant."""
    return GreyImage(picture.grey[rows:].copy(), picture.mask[rows:].copy())
