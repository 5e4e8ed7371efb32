"""Experiments made by computer in front of cameras, with what really happened."""

from dataclasses import dataclass

from shapemorph.core.arrays import Floats
from shapemorph.core.camera import Rig
from shapemorph.core.errors import DataError
from shapemorph.core.spline_map import SplineMap


@dataclass(frozen=True, slots=True, eq=False)
class StereoTwin:
    """A round sheet in all its states, and the cameras that look at it.

    Attributes
    ----------
    kind : str
        Name of the experiment.
    rig : Rig
        The true cameras; the world is the frame of the body: the flat sheet lies in z = 0.
    radius : float
        Of the sheet around material (0, 0), mm.
    maps : tuple of SplineMap
        Where the material is in each state, mm; these maps are the truth.
    travel : (S,) float64
        What each state was driven to, mm.
    """

    kind: str
    rig: Rig
    radius: float
    maps: tuple[SplineMap, ...]
    travel: Floats

    def __post_init__(self) -> None:
        if len(self.maps) < 2 or self.travel.shape != (len(self.maps),):
            raise DataError(
                f"a twin needs two or more states and what drove each, got {len(self.maps)} maps "
                f"and travel {self.travel.shape}"
            )
