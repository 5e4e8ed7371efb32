"""Stage `morph`: the deformed picture brought close to the reference."""

import numpy as np

from shapemorph.config import MorphConfig
from shapemorph.core.image import CalibratedImage, GreyImage
from shapemorph.core.matching import Matches, Warp
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.morphed import Morphed
from shapemorph.methods.morphing import morph_image, morph_surface


def morph(
    mesh: TexturedMesh,
    deformed: CalibratedImage,
    matches: Matches,
    shape: tuple[int, int],
    config: MorphConfig,
) -> Morphed:
    """Make the deformed surface look like the reference picture, straight from its texture.

    Parameters
    ----------
    mesh : TexturedMesh
        The deformed one.
    deformed : CalibratedImage
        Of that mesh.
    matches : Matches
    shape : (int, int)
        Height and width of the reference picture.
    config : MorphConfig
        Section ``morph`` of the run file.
    """
    warp = _law(matches, shape, config)
    return Morphed(morph_surface(mesh, deformed, warp, shape), warp)


def morph_pictures(
    deformed: GreyImage, matches: Matches, shape: tuple[int, int], config: MorphConfig
) -> Morphed:
    """Make a plain deformed picture look like the reference picture; see :func:`morph`."""
    warp = _law(matches, shape, config)
    return Morphed(morph_image(deformed, warp, shape), warp)


def _law(matches: Matches, shape: tuple[int, int], config: MorphConfig) -> Warp:
    return matches.forward if config.law == "warp" else identity_warp(shape)


def identity_warp(shape: tuple[int, int]) -> Warp:
    """Warp that leaves every point of a picture, and some room around it, where it is."""
    height, width = shape
    spacing = float(max(height, width, 16))
    origin = np.full(2, -2.0 * spacing)
    steps = np.arange(6.0)  # from -2 to 3 spacings; valid from -1 to 2
    cols, rows = np.meshgrid(steps, steps)
    return Warp(np.stack([cols, rows], axis=-1) * spacing + origin, origin, spacing)
