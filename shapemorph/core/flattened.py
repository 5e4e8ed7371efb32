"""Surfaces laid flat, and what that did to them."""

from dataclasses import dataclass

from shapemorph.core.arrays import Floats
from shapemorph.core.image import CalibratedImage
from shapemorph.core.laws import Dots


@dataclass(frozen=True, slots=True, eq=False)
class Distortion:
    """How a chart stretches its triangles.

    Attributes
    ----------
    sigma_1, sigma_2 : (M,) float64
        Singular values of the map from the triangle's plane to the picture, px per mm;
        sigma_1 >= |sigma_2|, and sigma_2 is negative where the triangle is flipped.
    area : (M,) float64
        Area of each triangle on the surface, mm^2.
    """

    sigma_1: Floats
    sigma_2: Floats
    area: Floats

    @property
    def flips(self) -> int:
        """Number of triangles that lie upside down."""
        return int((self.sigma_2 <= 0).sum())


@dataclass(frozen=True, slots=True, eq=False)
class FlattenedSurface:
    """One shape as a calibrated image.

    Attributes
    ----------
    calibrated : CalibratedImage
    distortion : Distortion
    method : str
        The flattening that was used in the end.
    reason : str
        One sentence: why this method and this scale.
    speckle_px, speckle_mm : float
        Size of a speckle (full width at half maximum of the autocorrelation), in the
        picture and on the surface (median).
    texels_per_px : float
        Texture samples per pixel, median; below 1 the picture is finer than its texture.
    """

    calibrated: CalibratedImage
    distortion: Distortion
    method: str
    reason: str
    speckle_px: float
    speckle_mm: float
    texels_per_px: float


@dataclass(frozen=True, slots=True, eq=False)
class FlattenedPair:
    """Both shapes as calibrated images.

    Attributes
    ----------
    reference, deformed : FlattenedSurface
    pairs : Dots or None
        Features that were matched to find which charts correspond, px of the two pictures.
    """

    reference: FlattenedSurface
    deformed: FlattenedSurface
    pairs: Dots | None = None
