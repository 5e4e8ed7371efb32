"""The speckle: dark round blobs on the material, the same for both sides."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.methods.synthetic.material import MaterialMap

CELLS_PER_DIAMETER = 1.2
"""Lattice cell over mean diameter: half of the surface is dark."""

EDGE = 0.25
"""Width of a soft edge over the mean diameter."""


@dataclass(frozen=True, slots=True, eq=False)
class Speckle:
    """One blob in every cell of a lattice over the material coordinates.

    Attributes
    ----------
    blobs : (R, C, 3) float64
        Position in the cell (0 to 1, x and y) and radius, mm. The lattice repeats.
    origin, cell : (2,) float64
        mm.
    edge : float
        Width over which a blob fades, mm.
    """

    blobs: Floats
    origin: Floats
    cell: Floats
    edge: float


def scatter_speckle(
    material_map: MaterialMap, *, diameter: float, rng: np.random.Generator
) -> Speckle:
    """Scatter blobs of the mean `diameter`, mm, over the material, half of it dark."""
    pitch = CELLS_PER_DIAMETER * diameter
    span = material_map.upper - material_map.lower
    counts = np.ceil(span / pitch).astype(np.int64) + 8
    cell, origin = np.full(2, pitch), material_map.lower - 4 * pitch
    if material_map.period is not None:
        counts[0] = max(round(material_map.period / pitch), 3)
        cell[0] = material_map.period / counts[0]
    places = rng.random((counts[1], counts[0], 2))
    radii = 0.5 * diameter * (1 + 0.25 * (2 * rng.random((counts[1], counts[0], 1)) - 1))
    blobs = np.concatenate([places, radii], axis=-1)
    return Speckle(blobs, origin, cell, EDGE * diameter)
