"""From two plain pictures to the grid that follows one into the other."""

from shapemorph.config import RunConfig
from shapemorph.core.errors import ConfigError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.laws import LawInputs
from shapemorph.core.matching import Matches, Warp
from shapemorph.core.morphed import Morphed
from shapemorph.pipeline.law_inputs import read_law_inputs


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


def match_pictures(
    left: GreyImage, right: GreyImage, inputs: LawInputs, config: RunConfig
) -> Matches:
    """Match features, else begin with the marks of the law; errors as the stage raises them."""
    from shapemorph.stages.match import match

    return match(left, right, config.match, inputs.dots)


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
    left: GreyImage, right: GreyImage, morphed: Morphed, config: RunConfig
) -> CorrelationGrid:
    """Follow the points of the left picture into the right one."""
    from shapemorph.stages.correlate import correlate

    def remorph(warp: Warp) -> GreyImage:
        return morph_by_warp(left, right, warp).image

    return correlate(left, remorph, morphed, config.correlate, None)
