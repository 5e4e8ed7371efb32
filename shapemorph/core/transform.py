"""Rigid motions, named ``target_from_source`` wherever they appear."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError


@dataclass(frozen=True, slots=True, eq=False)
class RigidTransform:
    """Rotation and translation that carry points of one frame into another.

    Attributes
    ----------
    rotation : (3, 3) float64
        Proper rotation, determinant +1.
    translation : (3,) float64
        In mm, added after the rotation.
    """

    rotation: Floats
    translation: Floats

    def __post_init__(self) -> None:
        if self.rotation.shape != (3, 3) or self.translation.shape != (3,):
            raise DataError(
                f"a rigid transform is a (3, 3) rotation and a (3,) translation, got "
                f"{self.rotation.shape} and {self.translation.shape}"
            )
        if not np.allclose(self.rotation @ self.rotation.T, np.eye(3), atol=1e-8) or (
            np.linalg.det(self.rotation) < 0
        ):
            raise DataError("the rotation of a rigid transform must be orthonormal, determinant +1")

    @classmethod
    def identity(cls) -> "RigidTransform":
        """Leave every point where it is."""
        return cls(np.eye(3), np.zeros(3))

    def apply(self, points: Floats) -> Floats:
        """Carry points (..., 3) from the source frame into the target frame."""
        return points @ self.rotation.T + self.translation

    def rotate(self, vectors: Floats) -> Floats:
        """Carry directions (..., 3): the rotation without the translation."""
        return vectors @ self.rotation.T

    def inverse(self) -> "RigidTransform":
        """Carry points back from the target frame into the source frame."""
        return RigidTransform(self.rotation.T, -self.rotation.T @ self.translation)
