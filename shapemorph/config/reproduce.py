"""Section `reproduce`: the paper's experiment as a synthetic twin, measured by its methods."""

from typing import Annotated

from pydantic import Field

from shapemorph.config.correlate import OddSize
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
