"""Section `flatten`: meshes to calibrated images."""

from pathlib import Path
from typing import Literal, Self

from pydantic import Field, model_validator

from shapemorph.config.section import Section, Vector3

FlatteningMethod = Literal[
    "auto",
    "bff",
    "lscm",
    "arap",
    "slim",
    "harmonic",
    "orthographic",
    "spherical",
    "cylindrical",
    "profile",
]
PARAMETERS_OF_METHODS = {
    "charts": ("auto", "bff", "lscm", "arap", "slim", "harmonic"),
    "axis": ("orthographic", "spherical", "cylindrical", "profile"),
    "centre": ("spherical", "cylindrical", "profile"),
    "projection": ("spherical",),
    "profile": ("profile",),
}


class FlattenConfig(Section):
    """Section `flatten`: meshes to calibrated images."""

    method: FlatteningMethod = Field(
        "auto", description="auto: boundary-first (bff), repaired or replaced where it flips"
    )
    px_per_mm: float | None = Field(
        None, gt=0, description="image scale; empty: from the size of the speckle"
    )
    speckle_px: float = Field(
        5.0, ge=3, le=20, description="size of a speckle that the automatic scale aims at, px"
    )
    max_megapixels: float = Field(
        16.0, gt=0, description="largest calibrated image; a finer scale is reduced to it"
    )
    charts: int | None = Field(
        None,
        ge=1,
        le=64,
        description="pieces that the largest component is split into; empty: as few as show it "
        "well",
    )
    axis: Vector3 | None = Field(
        None,
        description="towards the viewer (orthographic), from the centre to the picture's middle "
        "(spherical), or of symmetry (cylindrical, profile); empty: fitted",
    )
    centre: Vector3 | None = Field(
        None,
        description="centre of the ball (spherical) or a point of the axis (cylindrical, profile), "
        "mm, in the frame of each file; empty: fitted",
    )
    projection: Literal["equidistant", "equal_area", "stereographic"] | None = Field(
        None,
        description="kind of spherical: meridian lengths (equidistant, when empty), areas "
        "(equal_area) or angles (stereographic) are kept",
    )
    profile: Path | None = Field(
        None,
        description="CSV r,z of the meridian for profile, from the axis outward, in the units of "
        "the deformed file; empty, or where it does not fit: measured from the mesh",
    )

    @model_validator(mode="after")
    def _parameters_have_a_use(self) -> Self:
        for name, methods in PARAMETERS_OF_METHODS.items():
            if getattr(self, name) is not None and self.method not in methods:
                raise ValueError(
                    f"{name} is for method {', '.join(methods)}, got method {self.method}: "
                    "set one of these, or leave it empty"
                )
        return self
