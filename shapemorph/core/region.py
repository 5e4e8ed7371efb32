"""The part of the reference surface that a user wants measured."""

from dataclasses import dataclass

from shapemorph.core.arrays import Bools, Floats


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A limit on the reference surface; what is None does not limit.

    Attributes
    ----------
    polygon : (K, 2) float64 or None
        Corners in px of the flattened reference image.
    mask : (H, W) bool or None
        Picture of the size of the flattened reference image, True where measured.
    centre : (3,) float64 or None
        Centre of a ball, mm, in the frame of the reference file.
    radius : float or None
        Radius of the ball, mm.
    """

    polygon: Floats | None = None
    mask: Bools | None = None
    centre: Floats | None = None
    radius: float | None = None
