"""The part of the reference that a user wants measured."""

from dataclasses import dataclass

from shapemorph.core.arrays import Bools, Floats


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A limit on the reference surface or picture; what is None does not limit.

    Attributes
    ----------
    polygons : tuple of (K, 2) float64, or None
        Corners in px of the flattened reference image, or of the reference picture; what
        lies in any of them counts.
    holes : tuple of (K, 2) float64
        What lies in any of them does not count.
    mask : (H, W) bool or None
        Picture of the size of that image, True where measured.
    centre : (3,) float64 or None
        Centre of a ball, mm, in the frame of the reference file.
    radius : float or None
        Radius of the ball, mm.
    """

    polygons: tuple[Floats, ...] | None = None
    holes: tuple[Floats, ...] = ()
    mask: Bools | None = None
    centre: Floats | None = None
    radius: float | None = None
