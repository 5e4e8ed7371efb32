"""A smooth map from the plane of a material into space."""

from dataclasses import dataclass

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError


@dataclass(frozen=True, slots=True, eq=False)
class SplineMap:
    """Where every point of a flat sheet lies in space: a uniform bicubic B-spline.

    Attributes
    ----------
    coefficients : (R, C, 3) float64
        B-spline coefficients of the position, mm. Coefficient [r, c] sits at material
        coordinates ``origin + spacing * (c, r)``.
    origin : (2,) float64
        Material coordinates of coefficient [0, 0], mm.
    spacing : float
        Distance between coefficients, mm.
    """

    coefficients: Floats
    origin: Floats
    spacing: float

    def __post_init__(self) -> None:
        if self.coefficients.ndim != 3 or self.coefficients.shape[2] != 3:
            raise DataError(f"coefficients must be (R, C, 3), got {self.coefficients.shape}")
        if min(self.coefficients.shape[:2]) < 4:
            raise DataError("a cubic map needs at least 4 x 4 coefficients")
