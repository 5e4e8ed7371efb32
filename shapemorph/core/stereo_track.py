"""Points followed through the pictures of two cameras."""

from dataclasses import dataclass

from shapemorph.core.errors import DataError
from shapemorph.core.grid import CorrelationGrid


@dataclass(frozen=True, slots=True, eq=False)
class StereoGrids:
    """One grid of the first left picture, in the four pictures of two states.

    Attributes
    ----------
    across : CorrelationGrid
        First left picture -> first right picture.
    left, right : CorrelationGrid
        First left picture -> the later left and right picture.
    """

    across: CorrelationGrid
    left: CorrelationGrid
    right: CorrelationGrid

    def __post_init__(self) -> None:
        shapes = {grid.status.shape for grid in (self.across, self.left, self.right)}
        if len(shapes) > 1:
            raise DataError(f"the grids of two states must be one grid, got sizes {shapes}")
