"""Strain in the plane of a picture."""

from dataclasses import dataclass

from shapemorph.core.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class PlanarStrain:
    """Strain of a plane specimen at the points of a grid, axes x and y of the reference.

    Tensors have tensor shear; principal values have the larger first. NaN where there is
    no value.

    Attributes
    ----------
    gradient : (R, C, 2, 2) float64
        F_ij = d deformed[i] / d reference[j], from the fit over the window.
    green : (R, C, 2, 2) float64
        Green-Lagrange strain (F^T F - I) / 2.
    hencky : (R, C, 2, 2) float64
        Hencky strain ln(F^T F) / 2.
    green_principal, hencky_principal : (R, C, 2) float64
        E1 >= E2, and their logarithmic likes.
    window : int
        Points across the fitting window.
    gauge_px : float
        Virtual strain gauge: (window - 1) * spacing + subset size.
    """

    gradient: Floats
    green: Floats
    hencky: Floats
    green_principal: Floats
    hencky_principal: Floats
    window: int
    gauge_px: float
