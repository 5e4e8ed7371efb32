"""Points that a user has identified on both shapes."""

from dataclasses import dataclass

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError


@dataclass(frozen=True, slots=True, eq=False)
class Landmarks:
    """Named pairs of positions.

    Attributes
    ----------
    names : tuple of str
    reference, deformed : (K, 3) float64
        Positions in mm, each in the frame of its own file.
    """

    names: tuple[str, ...]
    reference: Floats
    deformed: Floats

    def __post_init__(self) -> None:
        count = len(self.names)
        if self.reference.shape != (count, 3) or self.deformed.shape != (count, 3):
            raise DataError(f"{count} landmarks need two arrays ({count}, 3)")
