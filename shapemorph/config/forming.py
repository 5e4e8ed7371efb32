"""Section `forming`: what a forming laboratory asks of the field."""

from pathlib import Path
from typing import Self

from pydantic import Field, model_validator

from shapemorph.config.section import Section, Vector3


class CutConfig(Section):
    """A plane that cuts the reference; what was measured is drawn along the cut."""

    name: str = Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$", description="of the files: letters, digits, - and _"
    )
    point: Vector3 | None = Field(
        None,
        description="of the plane, in the reference file's units and frame; empty: the middle of "
        "what was measured",
    )
    normal: Vector3 | None = Field(None, description="of the plane, in the same frame")
    angle: float | None = Field(
        None,
        description="instead of a normal: a diameter in this direction about the mean normal of "
        "the reference, degrees from its x axis",
    )

    @model_validator(mode="after")
    def _plane_is_settled(self) -> Self:
        if (self.normal is None) == (self.angle is None):
            raise ValueError("normal and angle both settle the plane: give one of them")
        if self.normal is not None and not any(self.normal):
            raise ValueError("normal must have a length, got 0, 0, 0")
        return self


class FormingConfig(Section):
    """Section `forming`: forming-limit diagram, sections, dome; nothing unless asked for."""

    diagram: bool = Field(
        False, description="draw the forming-limit diagram without a limit curve, too"
    )
    limit_curve: Path | None = Field(
        None,
        description="CSV eps2,eps1 of the forming-limit curve, Hencky; lines `# key: value` state "
        "its material, thickness (mm), temperature (C)",
    )
    material: str | None = Field(None, description="of the specimen, compared with the curve's")
    temperature: float | None = Field(
        None, description="of the forming, C, compared with the curve's"
    )
    sections: tuple[CutConfig, ...] = Field(
        (), description="cuts: a table and a figure of displacement and strain along each"
    )
    dome: bool = Field(False, description="height, pole and radius of curvature of a dome")
    pressure: float | None = Field(
        None,
        gt=0,
        description="on the dome, MPa: membrane stress p R / 2 t; needs strain.thickness",
    )
    cap: float | None = Field(
        None,
        gt=0,
        description="radius about the pole that its curvature is fitted over, mm; empty: a "
        "quarter of the way to the rim",
    )

    @property
    def wants_diagram(self) -> bool:
        """Whether a forming-limit diagram is asked for."""
        return self.diagram or self.limit_curve is not None

    @property
    def wants_dome(self) -> bool:
        """Whether the dome is asked for."""
        return self.dome or self.pressure is not None

    @model_validator(mode="after")
    def _names_are_different(self) -> Self:
        names = [cut.name for cut in self.sections]
        if len(set(names)) < len(names):
            raise ValueError(f"each section needs a name of its own, got {', '.join(names)}")
        return self

    @model_validator(mode="after")
    def _settings_have_a_use(self) -> Self:
        if self.cap is not None and not self.wants_dome:
            raise ValueError("cap is for the curvature of a dome: set dome or pressure")
        if (self.material or self.temperature is not None) and self.limit_curve is None:
            raise ValueError("material and temperature are compared with a limit_curve: give one")
        return self
