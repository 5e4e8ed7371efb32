"""Section `inputs`: what is measured."""

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from shapemorph.config.section import Section, Unit, Vector3

Channel = Literal["auto", "luma", "red", "green", "blue"]


Polygon = Annotated[list[tuple[float, float]], Field(min_length=3)]


class RegionConfig(Section):
    """A part of the reference; every given limit applies."""

    polygon: Polygon | None = Field(
        None,
        description="corners (x, y) in px of the flattened reference image, or of the reference "
        "picture where pictures are measured",
    )
    polygons: Annotated[list[Polygon], Field(min_length=1)] | None = Field(
        None, description="several of them; the region is what lies in any"
    )
    holes: Annotated[list[Polygon], Field(min_length=1)] | None = Field(
        None, description="polygons that are left out"
    )
    mask: Path | None = Field(
        None, description="picture of the size of that image, white = measured"
    )
    centre: Vector3 | None = Field(
        None,
        description="centre of a ball, in the reference file's units and frame; of meshes only",
    )
    radius: float | None = Field(None, gt=0, description="radius of the ball, in the same units")

    @model_validator(mode="after")
    def _ball_is_whole(self) -> Self:
        if (self.centre is None) != (self.radius is None):
            raise ValueError("centre and radius describe a ball together: give both or neither")
        return self


class InputsConfig(Section):
    """What is measured."""

    reference: Path | None = Field(
        None, description="textured mesh, or picture, before the deformation"
    )
    deformed: Path | None = Field(None, description="the same after the deformation")
    sequence: Path | None = Field(
        None,
        description="pictures of one view instead of the two: a pattern such as frames/*.tif, or "
        "a TIFF of many pages; the first is the reference",
    )
    left: Path | None = Field(
        None, description="pictures of the left camera, one for each state, such as left_*.png"
    )
    right: Path | None = Field(None, description="pictures of the right camera, likewise")
    rig: Path | None = Field(
        None, description="calibrated cameras of left and right, such as calibration.json"
    )
    units: Unit = Field("mm", description="length unit of both files, whatever their format")
    reference_units: Unit | None = Field(None, description="overrides units for the reference")
    deformed_units: Unit | None = Field(None, description="overrides units for the deformed")
    channel: Channel = Field(
        "auto",
        description="what of the colours becomes grey, on both sides; auto: luma, unless a channel "
        "shows twice its gradient",
    )
    landmarks: Path | None = Field(
        None, description="CSV name,ref_x,ref_y,ref_z,def_x,def_y,def_z in the frames of the files"
    )
    region: RegionConfig | None = Field(None, description="limits the measurement")

    @model_validator(mode="after")
    def _sequence_stands_alone(self) -> Self:
        if self.sequence is not None and (self.reference or self.deformed):
            raise ValueError(
                "sequence stands instead of reference and deformed: give one or the other"
            )
        if self.left is not None and (self.reference or self.deformed or self.sequence):
            raise ValueError(
                "left and right stand instead of reference, deformed and sequence: give one or "
                "the other"
            )
        return self
