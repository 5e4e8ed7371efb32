"""Pairs made by computer, with what really happened to them."""

from dataclasses import dataclass

from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.errors import DataError
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.transform import RigidTransform


@dataclass(frozen=True, slots=True, eq=False)
class DamageSpot:
    """A round part of the material whose pattern was spoilt on the deformed side.

    Attributes
    ----------
    kind : str
        "glare", "lost_patch" or "print".
    centre : (2,) float64
        Material coordinates, mm.
    radius : float
        Of the part that counts as not visible, in material coordinates, mm.
    """

    kind: str
    centre: Floats
    radius: float


@dataclass(frozen=True, slots=True, eq=False)
class TruthPoints:
    """What really happened at some material points.

    Attributes
    ----------
    material : (N, 2) float64
        Material coordinates, mm.
    reference, deformed : (N, 3) float64
        Exact positions, mm, each in the frame of its own file.
    e1, e2 : (N,) float64
        Principal Green-Lagrange strains, e1 >= e2.
    rim_distance : (N,) float64
        To the nearest rim of the specimen, mm of the reference, negative outside.
    kink_distance : (N,) float64
        To the nearest line across which F jumps, mm of the reference; inf where
        the map has none.
    visible : (N,) bool
        False where the pattern of the deformed side is damaged.
    """

    material: Floats
    reference: Floats
    deformed: Floats
    e1: Floats
    e2: Floats
    rim_distance: Floats
    kink_distance: Floats
    visible: Bools

    def __post_init__(self) -> None:
        for name in ("reference", "deformed", "e1", "e2", "rim_distance", "visible"):
            if len(getattr(self, name)) != len(self.material):
                raise DataError(f"{name} must have a row for each of {len(self.material)} points")


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """Everything that is needed to say what really happened, exactly.

    Attributes
    ----------
    shape : str
        Name of the material map.
    size : float
        Diameter or length of the object, mm.
    offset : float
        Distance of the punch from the centre, mm; only the indentation reads it.
    tilt : float
        Tilt of the punch, radians; likewise.
    reference_pose, deformed_pose : RigidTransform
        file_from_body for both sides.
    damage : tuple of DamageSpot
    table : TruthPoints
        The same truth on a regular grid of the material, for those who only read arrays.
    """

    shape: str
    size: float
    offset: float
    tilt: float
    reference_pose: RigidTransform
    deformed_pose: RigidTransform
    damage: tuple[DamageSpot, ...]
    table: TruthPoints


@dataclass(frozen=True, slots=True, eq=False)
class SyntheticPair:
    """Two textured meshes of one object and the truth about them."""

    reference: TexturedMesh
    deformed: TexturedMesh
    truth: Truth
