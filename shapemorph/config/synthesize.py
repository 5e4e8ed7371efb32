"""Section `synthesize`: a textured pair with exact truth."""

from typing import Literal

from pydantic import Field

from shapemorph.config.section import Section


class DamageConfig(Section):
    """What went wrong with the pattern of the deformed side."""

    glare: bool = Field(False, description="a saturated spot")
    lost_patch: bool = Field(False, description="a patch without pattern")
    print_at_pole: bool = Field(False, description="a foreign mark at the pole")


class SynthesizeConfig(Section):
    """Section `synthesize`: a textured pair with exact truth."""

    shape: Literal[
        "dome", "bulge", "indentation", "freeform", "hole", "tube", "rigid", "balloon", "sheet"
    ] = Field("bulge", description="kind of deformation")
    size: float = Field(70.0, gt=0, description="diameter or length of the object, mm")
    speckle: float = Field(0.8, gt=0, description="diameter of a speckle on the material, mm")
    faces: int = Field(40_000, ge=200, description="triangles of each mesh, about")
    texture: int = Field(2048, ge=64, le=16384, description="width of the square texture, px")
    grey_noise: float = Field(2.0, ge=0, description="noise of the texture, grey levels of 255")
    vertex_noise: float = Field(
        0.006, ge=0, description="noise of every vertex coordinate, mm, one sigma"
    )
    seed: int = Field(0, ge=0, description="of everything random")
    format: Literal["obj", "glb", "ply"] = Field("obj", description="file format of both sides")
    offset: float = Field(0.0, description="indentation: distance of the punch from the centre, mm")
    tilt: float = Field(0.0, ge=-20, le=20, description="indentation: tilt of the punch, degrees")
    stretch: float = Field(2.0, gt=0, description="sheet: stretch along its direction")
    direction: float = Field(
        0.0,
        description="sheet: of the stretch, from the long side of the sheet; freeform: of all that "
        "happens to it, against the reference; degrees",
    )
    turn: float = Field(0.0, description="sheet: turned in its plane afterwards, degrees")
    damage: DamageConfig = DamageConfig()
