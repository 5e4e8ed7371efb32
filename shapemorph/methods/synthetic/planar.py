"""Flat pictures of one speckle, undeformed and deformed, with the exact map between them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.image import GreyImage

EDGE = 0.3  # width of the soft edge of a speckle, in diameters
PITCH = 0.85  # distance between speckles, in diameters

Map = Callable[[Floats], Floats]


class Painted(Protocol):
    """Anything that has a grey level at every material point."""

    def at(self, points: Floats) -> Floats:
        """Grey, about N(0, 1), at points (..., 2)."""


@dataclass(frozen=True, slots=True, eq=False)
class PlanarSpeckle:
    """Soft discs of random place, size and strength, one in each cell of a lattice.

    Attributes
    ----------
    places, radii, strengths : (R, R, 2), (R, R), (R, R) float64
        Per cell: position in the cell (0 to 1), radius in px, height. The lattice repeats.
    diameter : float
        Mean diameter of a disc, px.
    """

    places: Floats
    radii: Floats
    strengths: Floats
    diameter: float

    def at(self, points: Floats) -> Floats:
        """Evaluate the pattern exactly at material points (..., 2), px; about N(0, 1)."""
        scaled = points / (PITCH * self.diameter)
        cell = np.floor(scaled).astype(np.int64)
        total = np.zeros(points.shape[:-1])
        for dy in (-1, 0, 1):
            for dx in (-1, 0, 1):
                total += self._disc(cell + np.array([dx, dy]), points)
        return total

    def _disc(self, cell: Ints, points: Floats) -> Floats:
        size = self.radii.shape[0]
        pick = (cell[..., 1] % size, cell[..., 0] % size)
        centre = (cell + self.places[pick]) * PITCH * self.diameter
        distance = np.hypot(*np.moveaxis(points - centre, -1, 0))
        depth = (self.radii[pick] - distance) / (EDGE * self.diameter) + 0.5
        inside = np.clip(depth, 0.0, 1.0)
        disc: Floats = self.strengths[pick] * inside * inside * (3.0 - 2.0 * inside)
        return disc


def planar_speckle(*, diameter: float, seed: int) -> PlanarSpeckle:
    """Scatter discs of a mean diameter, px."""
    rng = np.random.default_rng(seed)
    size = 512
    radii = 0.5 * diameter * rng.uniform(0.75, 1.25, (size, size))
    strengths = rng.choice([-1.0, 1.0], (size, size)) * rng.uniform(0.7, 1.3, (size, size))
    return PlanarSpeckle(rng.random((size, size, 2)), radii, strengths, diameter)


@dataclass(frozen=True, slots=True, kw_only=True)
class Exposure:
    """Light and noise of one picture.

    Attributes
    ----------
    gain, offset, slope : float
        Contrast; added grey; added grey across the width.
    noise : float
        Standard deviation of the grey noise, levels of 255.
    seed : int
        Of the noise.
    blur : float
        Standard deviation of the blur of the lens, px.
    """

    gain: float
    offset: float
    slope: float
    noise: float
    seed: int
    blur: float = 0.0


def take_picture(
    speckle: Painted,
    shape: tuple[int, int],
    exposure: Exposure,
    *,
    material_at: Map,
    inside: Callable[[Floats], Bools],
) -> GreyImage:
    """Take a picture of a pattern that lies anyhow.

    Parameters
    ----------
    speckle : PlanarSpeckle, PlanarTexture or the like
    shape : (H, W)
    exposure : Exposure
    material_at : callable (..., 2) -> (..., 2)
        Material point (px of the undeformed picture) that is seen at a pixel (x, y).
    inside : callable (..., 2) -> (...)
        Whether a material point belongs to the specimen.
    """
    rows, cols = np.mgrid[: shape[0], : shape[1]].astype(np.float64)
    material = material_at(np.stack([cols, rows], axis=-1))
    mask = inside(material)
    pattern = _blurred(speckle.at(material), exposure.blur)
    grey = 0.5 + 0.18 * exposure.gain * pattern + exposure.offset
    grey += exposure.slope * (cols / shape[1] - 0.5)
    grey += np.random.default_rng(exposure.seed).normal(0.0, exposure.noise / 255, shape)
    levels = np.rint(255 * np.clip(grey, 0.0, 1.0)) / 255
    return GreyImage(np.where(mask, levels, 0.0).astype(np.float32), mask)


def _blurred(pattern: Floats, blur: float) -> Floats:
    import cv2

    if blur == 0:
        return pattern
    soft: Floats = cv2.GaussianBlur(pattern, (0, 0), blur)
    return soft


def inverse_at(material_at: Map, points: Floats, start: Floats) -> Floats:
    """Find where material points (N, 2) are seen: Newton's method on the map of the picture.

    Parameters
    ----------
    material_at : callable (N, 2) -> (N, 2)
        Smooth; pixel -> material.
    points : (N, 2)
        Material points, px.
    start : (N, 2)
        Pixels near the solution.
    """
    found = start.copy()
    for _ in range(25):
        jacobian = np.stack(
            [(material_at(found + h) - material_at(found - h)) / 2e-4 for h in 1e-4 * np.eye(2)], -1
        )
        misfit = points - material_at(found)
        found = found + np.linalg.solve(jacobian, misfit[..., None])[..., 0]
    return found
