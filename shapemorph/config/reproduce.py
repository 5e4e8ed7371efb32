"""Sections `reproduce` and `bulge`: the paper's experiments as synthetic twins, measured."""

from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from shapemorph.config.correlate import OddSize
from shapemorph.config.morph import Law
from shapemorph.config.section import Section
from shapemorph.config.twin import TwinConfig


class ReproduceConfig(Section):
    """Section `reproduce`: what is measured of the twin, and how."""

    twin: TwinConfig = TwinConfig()
    subset_size: OddSize = Field(21, description="of our own settings, px")
    spacing: Annotated[int, Field(ge=1, le=200)] = Field(8, description="of both settings, px")
    noises: tuple[float, ...] = Field(
        (4.0, 8.0, 16.0),
        description="further noise that image-morphing is tried with, levels of 255",
    )
    states: int = Field(
        5,
        ge=0,
        description="states, evenly chosen, at which every method is tried for its limit; 0: none",
    )
    paper: bool = Field(True, description="measure with the paper's settings, too")
    figures: bool = Field(True, description="draw the figures of the page")


FRAMES = 126
"""Of a turn: seven steps are 20 degrees, six lie between 21 pairs that are evenly spread."""


class BulgeConfig(Section):
    """Section `bulge`: the sheet on its turntable, from photographs to strain."""

    twin: TwinConfig = TwinConfig(kind="bulge", frames=FRAMES)
    patches: int = Field(21, ge=1, description="pairs of views that are matched for each state")
    subset_size: OddSize = Field(21, description="in the photographs, px")
    spacing: Annotated[int, Field(ge=1, le=200)] = Field(8, description="likewise")
    laws: tuple[Law, ...] = Field(
        ("fe", "landmarks"),
        min_length=1,
        description="morph laws that both shapes are measured with, each by itself",
    )
    noises: tuple[float, ...] = Field(
        (4.0, 8.0),
        description="further noise that everything is repeated with, levels of 255",
    )
    figures: bool = Field(True, description="draw the figures of the page")

    @model_validator(mode="before")
    @classmethod
    def _is_a_bulge(cls, given: Any) -> Any:
        if isinstance(given, dict) and isinstance(twin := given.get("twin", {}), dict):
            return {**given, "twin": {"kind": "bulge", "frames": FRAMES, **twin}}
        return given

    @model_validator(mode="after")
    def _turns(self) -> Self:
        if self.twin.kind != "bulge" or not self.twin.frames:
            raise ValueError(
                f"expected twin.kind bulge with frames, got {self.twin.kind} with "
                f"{self.twin.frames}: the membrane is in section reproduce"
            )
        return self
