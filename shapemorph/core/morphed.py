"""The deformed picture brought close to the reference."""

from dataclasses import dataclass

from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp


@dataclass(frozen=True, slots=True, eq=False)
class Morphed:
    """A deformed picture resampled in the frame of the reference.

    Attributes
    ----------
    image : GreyImage
        Of the shape of the reference picture.
    warp : Warp
        Reference -> deformed; pixel x of `image` shows the deformed picture at warp(x).
    overruled : int
        Matches that took over where the morph law leads nowhere.
    """

    image: GreyImage
    warp: Warp
    overruled: int = 0
