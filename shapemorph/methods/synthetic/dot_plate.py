"""A plate with rows of dots, to calibrate cameras with."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from shapemorph.core.arrays import Floats
from shapemorph.core.spline_map import SplineMap
from shapemorph.core.transform import RigidTransform
from shapemorph.methods.synthetic.speckle import Speckle

FAR = 1e6  # cells away: no dot


@dataclass(frozen=True, slots=True)
class DotPlate:
    """Dots in rows and columns on a round plate.

    Attributes
    ----------
    columns, rows : int
    spacing, diameter : float
        mm.
    radius : float
        Of the plate, mm; the dots lie in its middle.
    """

    columns: int
    rows: int
    spacing: float
    diameter: float
    radius: float

    def pattern(self) -> Speckle:
        """Give the dots as a speckle: one in each cell of a lattice, none beside the rows."""
        around = int(np.ceil(self.radius / self.spacing)) + 2
        blobs = np.zeros((self.rows + 2 * around, self.columns + 2 * around, 3))
        blobs[..., 0] = FAR
        inner = slice(around, around + self.rows), slice(around, around + self.columns)
        blobs[inner] = [0.5, 0.5, 0.5 * self.diameter]
        low = -self.spacing * (0.5 * np.array([self.columns, self.rows]) + around)
        return Speckle(blobs, low, np.full(2, self.spacing), 0.02 * self.diameter)

    def placed(self, pose: RigidTransform) -> SplineMap:
        """Map of the plate, laid somewhere in space."""
        step = self.radius / 4
        line = step * np.arange(-7.0, 8.0)
        x, y = np.meshgrid(line, line)
        flat = np.stack([x, y, np.zeros_like(x)], axis=-1)
        return SplineMap(pose.apply(flat), np.array([line[0], line[0]]), step)


def random_plate_pose(target: Floats, rng: np.random.Generator) -> RigidTransform:
    """Lay a plate near a point (3,), tilted by up to 25 and turned by up to 15 degrees."""
    turn = np.deg2rad(rng.uniform([-25, -25, -15], [25, 25, 15]))
    shift = rng.uniform(-1, 1, 3) * np.array([12.0, 6.0, 10.0])
    return RigidTransform(Rotation.from_euler("xyz", turn).as_matrix(), target + shift)
