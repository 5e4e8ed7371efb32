"""Section `twin`: rendered pictures of a stereo rig with exact truth."""

from typing import Literal, Self

from pydantic import Field, model_validator

from shapemorph.config.section import Section


class TwinConfig(Section):
    """Section `twin`: a synthetic experiment in front of two cameras."""

    kind: Literal["membrane", "bulge"] = Field(
        "membrane",
        description="membrane: a rubber disc of 76 mm that a round punch is pushed into; bulge: a "
        "hot sheet of 1.35 mm that gas blows into a die of 45 mm",
    )
    law: Literal["fe", "analytic"] = Field(
        "fe",
        description="fe: finite elements; analytic: a closed form that grows, quick (membrane: a "
        "cap and a cone; bulge: a hemisphere and a wall, stretched by two along its meridians)",
    )
    scale: float = Field(
        1.0,
        ge=0.1,
        le=2,
        description="size of the pictures, 1: 2352 x 1728 px; the speckle keeps its size in px",
    )
    steps: int = Field(16, ge=1, le=64, description="states after the first one")
    travel: float = Field(
        32.0, gt=0, le=34, description="membrane: way of the punch in all steps, mm"
    )
    offset: float = Field(
        4.0, ge=-10, le=10, description="membrane: of the punch from the centre, mm"
    )
    tilt: float = Field(5.0, ge=-15, le=15, description="membrane: of the punch, degrees")
    height: float = Field(
        1.1, ge=0.4, le=1.4, description="bulge by fe: of its middle in the end, over the radius"
    )
    exponent: float = Field(
        0.5, ge=0.3, le=1, description="bulge by fe: m of the flow stress K rate^m, the sensitivity"
    )
    frames: int = Field(
        360,
        ge=0,
        le=720,
        description="bulge: pictures of each state on a turntable, evenly around, by one camera; "
        "0: two cameras that look from above instead",
    )
    rings: int = Field(
        24, ge=8, le=80, description="rings of elements; 6 times their square triangles"
    )
    speckle_px: float = Field(
        6.0, ge=3, le=20, description="diameter of a speckle in the first picture, px"
    )
    samples: int = Field(2, ge=1, le=8, description="rays along each side of a pixel")
    blur_px: float = Field(0.6, ge=0, le=5, description="blur of lens and sensor, one sigma, px")
    noise: float = Field(1.5, ge=0, le=50, description="of the grey, one sigma, levels of 255")
    gloss: float = Field(0.15, ge=0, le=5, description="strength of highlights")
    views: int = Field(
        12, ge=0, le=100, description="pictures of a calibration target for each camera"
    )
    seed: int = Field(0, ge=0, description="of everything random")

    @model_validator(mode="after")
    def _can_be_made(self) -> Self:
        if self.kind == "membrane" and self.law == "analytic" and self.travel > 32.0:
            raise ValueError(
                f"law analytic knows 32 mm of travel, got {self.travel:g}: lower travel or choose "
                "law fe"
            )
        if 0 < self.frames < 2:
            raise ValueError(f"a turn needs two or more frames, got {self.frames}: or 0 for none")
        return self
