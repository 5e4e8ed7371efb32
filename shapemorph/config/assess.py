"""Section `assess`: how well pictures can be correlated."""

from typing import Literal, Self

from pydantic import Field, model_validator

from shapemorph.config.section import Section


class StarConfig(Section):
    """A picture pair whose displacement has one amplitude and a period that grows along x."""

    periods: tuple[float, float] = Field(
        (10.0, 300.0),
        description="in the first and in the last column of the picture, px; linear between",
    )
    amplitude: float = Field(0.5, gt=0, description="px")
    component: Literal["u", "v"] = Field("v", description="which displacement is imposed")
    row: float | None = Field(
        None, description="where the amplitude is the same at all periods, px; empty: the middle"
    )

    @model_validator(mode="after")
    def _periods_grow(self) -> Self:
        if not 2.0 <= self.periods[0] < self.periods[1]:
            raise ValueError(f"periods must grow from 2 px or more, got {list(self.periods)}")
        return self


class AssessConfig(Section):
    """Section `assess`: how well pictures can be correlated."""

    star: StarConfig | None = Field(
        None, description="the pair is a star pattern: spatial resolution and MEI are measured"
    )
