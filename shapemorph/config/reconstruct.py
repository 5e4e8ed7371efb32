"""Section `reconstruct`: two views of one state to a surface."""

from pydantic import Field

from shapemorph.config.section import Section


class ReconstructConfig(Section):
    """Section `reconstruct`: two views of one state to a surface."""

    max_epipolar: float | None = Field(
        None,
        gt=0,
        description="px: points that lie farther off their epipolar line are lost; empty: six "
        "times what is usual",
    )
    orient: bool = Field(
        False,
        description="find anew how the second camera is turned and to which side it stands, from "
        "the pictures; lenses and distance of the cameras are kept",
    )
    smooth: bool = Field(
        False,
        description="smooth the disparities by B-splines as stiff as predicts left-out points best",
    )
