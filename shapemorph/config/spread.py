"""Section `spread`: the same pair measured in other ways."""

from typing import Self

from pydantic import Field, model_validator

from shapemorph.config.correlate import OddSize
from shapemorph.config.flatten import FlatteningMethod
from shapemorph.config.section import Section


class SpreadConfig(Section):
    """Section `spread`: what the whole measurement is repeated with; see `morph.laws`, too."""

    flattenings: tuple[FlatteningMethod, ...] = Field(
        (), description="further methods of flattening to measure with"
    )
    subset_sizes: tuple[OddSize, ...] = Field(
        (), description="further widths of a subset to measure with, odd, px"
    )

    @model_validator(mode="after")
    def _subsets_have_a_centre(self) -> Self:
        if any(size % 2 == 0 for size in self.subset_sizes):
            raise ValueError(f"subset_sizes must be odd, got {list(self.subset_sizes)}")
        return self
