"""Section `morph`: the deformed image brought close to the reference."""

from pathlib import Path
from typing import Literal, Self

from pydantic import Field, model_validator

from shapemorph.config.section import Section, Unit

Law = Literal["warp", "polynomial", "landmarks", "fe", "identity"]


class MorphConfig(Section):
    """Section `morph`: the deformed image brought close to the reference."""

    law: Law = Field(
        "warp",
        description="warp: free two-dimensional, from the matches; polynomial: r_m of the radius; "
        "landmarks: through marks; fe: from a finite element result; identity: nothing deformed",
    )
    laws: tuple[Law, ...] = Field(
        (), description="further laws to measure with; their spread is a systematic uncertainty"
    )
    order: int = Field(3, ge=1, le=9, description="polynomial: highest power of the radius")
    centre: tuple[float, float] | None = Field(
        None, description="polynomial, landmarks: centre in the flattened reference, px"
    )
    coefficients: list[float] | None = Field(
        None, min_length=1, description="polynomial: c_1, c_2, ... in mm of the flattened images"
    )
    dots: Path | None = Field(
        None,
        description="landmarks: CSV x_ref_px,y_ref_px,x_def_px,y_def_px in the flattened images; "
        "empty: those of inputs.landmarks",
    )
    fe: Path | None = Field(
        None, description="fe: CSV r0,r,z or x,y,z,ux,uy,uz, frd, or what meshio reads (vtu, inp)"
    )
    fe_model: Literal["solid", "axisymmetric"] = Field(
        "solid", description="fe: axisymmetric meshes have the radius as x and the axis as y"
    )
    fe_deformed: Path | None = Field(
        None, description="fe: mesh with the same nodes after the deformation"
    )
    fe_displacement: str | None = Field(None, description="fe: name of the displacements")
    fe_units: Unit | None = Field(None, description="fe: length unit; empty: the reference's")
    images: int | None = Field(
        None,
        ge=0,
        multiple_of=2,
        description="synthetic images of the morph sequence (N - 2); empty: from strain and ZNCC",
    )

    @property
    def all_laws(self) -> tuple[Law, ...]:
        """Every law that is asked for, the main one first, each once."""
        return tuple(dict.fromkeys((self.law, *self.laws)))

    @model_validator(mode="after")
    def _laws_have_their_files(self) -> Self:
        if "fe" in self.all_laws and self.fe is None:
            raise ValueError("law fe needs the path of a finite element result: give morph.fe")
        return self
