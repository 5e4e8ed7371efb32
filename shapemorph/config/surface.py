"""Sections `lift`, `align` and `strain`: from grids to a field on the surface."""

from typing import Literal, Self

from pydantic import Field, model_validator

from shapemorph.config.inputs import RegionConfig
from shapemorph.config.section import Section


class LiftConfig(Section):
    """Section `lift`: grid positions to points in space."""

    max_extrapolation_px: float = Field(
        1.0, ge=0, description="farthest a match may lie outside the mesh and still be placed, px"
    )


class AlignConfig(Section):
    """Section `align`: the rigid motion between the two files."""

    method: Literal["auto", "landmarks", "icp", "landmarks+icp", "points", "none"] = Field(
        "auto",
        description="auto: landmarks where given, else a robust fit to matched points; none: both "
        "files are in one frame",
    )
    rigid_region: RegionConfig | None = Field(
        None, description="part of the reference that did not deform; icp and points use only it"
    )
    icp_iterations: int = Field(50, ge=1, description="most iterations of ICP")

    @model_validator(mode="after")
    def _region_has_a_use(self) -> Self:
        if self.rigid_region is not None and self.method in ("landmarks", "none"):
            raise ValueError(
                "rigid_region is for method icp, landmarks+icp, points or auto, got method "
                f"{self.method}, which takes no points of the surface: leave one of the two out"
            )
        return self


class StrainConfig(Section):
    """Section `strain`: the local fit."""

    window: int = Field(5, ge=3, le=51, description="points across the fitting window, odd")
    thickness: float | None = Field(
        None, gt=0, description="of the sheet before the deformation, mm: gives a map of thickness"
    )
    surface: Literal["middle", "outer", "inner"] = Field(
        "middle",
        description="what was measured of a sheet; outer: the skin that its normals (faces "
        "counter-clockwise) point away from, as scanners see it; inner: the one that they point "
        "into; strain is carried to the middle",
    )

    @model_validator(mode="after")
    def _window_has_a_centre(self) -> Self:
        if self.window % 2 == 0:
            raise ValueError(f"window must be odd, got {self.window}")
        return self

    @model_validator(mode="after")
    def _skin_has_a_thickness(self) -> Self:
        if self.surface != "middle" and self.thickness is None:
            raise ValueError(f"surface {self.surface} needs the thickness of the sheet: give both")
        return self
