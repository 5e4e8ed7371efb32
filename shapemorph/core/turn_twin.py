"""A sheet on a turntable, made by computer, with what really happened."""

from dataclasses import dataclass

from shapemorph.core.calibration import Target
from shapemorph.core.camera import Camera
from shapemorph.core.errors import DataError
from shapemorph.core.spline_map import SplineMap
from shapemorph.core.transform import RigidTransform


@dataclass(frozen=True, slots=True, eq=False)
class TurnTwin:
    """A round sheet before and after, and the camera that sees it turn.

    Attributes
    ----------
    camera : Camera
        The true one; its frame is the world.
    poses : tuple of RigidTransform
        world_from_target for each picture, the same before and after.
    target : Target
        Dots that turn with the sheet; its frame is that of the part.
    radius : float
        Of the die around material (0, 0), mm: what lies beyond is clamped.
    edge : float
        Of the sheet with its flange, mm.
    maps : (SplineMap, SplineMap)
        Where the material is before and after, mm, in the frame of the die; these are the truth.
    placed : (RigidTransform, RigidTransform)
        part_from_die before and after: how the sheet was put onto the turntable.
    """

    camera: Camera
    poses: tuple[RigidTransform, ...]
    target: Target
    radius: float
    edge: float
    maps: tuple[SplineMap, SplineMap]
    placed: tuple[RigidTransform, RigidTransform]

    def __post_init__(self) -> None:
        if len(self.poses) < 2 or self.target.normals is None:
            raise DataError(
                f"a turn needs two or more poses of a target in space, got {len(self.poses)}"
            )
