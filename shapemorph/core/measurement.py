"""Everything that was measured, point by point, as users read it."""

from dataclasses import dataclass

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import DataError


@dataclass(frozen=True, slots=True, eq=False)
class Facets:
    """Triangles between measured points, each with one strain: nothing smoothed.

    Attributes
    ----------
    corners : (T, 3) int64
        Row numbers of the measurement, counter-clockwise seen from the outer side.
    arrays : dict of str to (T,) array
        By the names of the file contract.
    """

    corners: Ints
    arrays: dict[str, Floats]

    def __post_init__(self) -> None:
        for name, values in self.arrays.items():
            if len(values) != len(self.corners):
                raise DataError(f"{name} has {len(values)} rows for {len(self.corners)} facets")


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """The points inside the mask, one row each, with the arrays of the result files.

    Attributes
    ----------
    reference : (N, 3) float64
        Positions in mm in the frame of the reference file, finite for lost points too.
    cells : (M, 4) int64
        Quads between neighbours that are all OK, as row numbers, counter-clockwise seen
        from the outer side.
    arrays : dict of str to array
        Point arrays by the names of the file contract (status, chart, deformed_position, ...).
    grid_index : (N,) int64 or None
        Number of each point in the flattened correlation grid; None: not from a grid.
    facets : Facets or None
        Two triangles for each quad; None: not from a grid.
    """

    reference: Floats
    cells: Ints
    arrays: dict[str, Floats]
    grid_index: Ints | None = None
    facets: Facets | None = None

    def __post_init__(self) -> None:
        for name, values in self.arrays.items():
            if len(values) != len(self.reference):
                raise DataError(f"{name} has {len(values)} rows for {len(self.reference)} points")
