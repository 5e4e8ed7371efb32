"""Pictures of a speckle that is known exactly, before and after motions that are known exactly.

The pattern is a sum of Gaussian blobs, one at a random place of each cell, softly squeezed
between black and white. The size of the speckle is the diameter of a blob at half its height.
Pixels are averages of 4 x 4 samples, in whole levels of 255.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from shapemorph.core.image import GreyImage

SIZE, SPACING, SUPERSAMPLES = 1000, 8, 4
CELL = 0.8  # distance of the blobs of the pattern, one in each cell, in speckles
WIDTH = 0.5 / np.sqrt(2 * np.log(2))  # standard deviation of a blob, in speckles
FARTHEST = 12.0  # exponent of a blob beyond which nothing is left of it: 6e-6 of its height
CELLS = 1024  # along each side, after which the pattern repeats: seen in no picture
SPECKLE = 4.5  # px
CENTRE = np.array([SIZE / 2, SIZE / 2])
Map = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Case:
    """A deformation and its exact inverse."""

    name: str
    forward: Map
    back: Map
    orders: tuple[int, ...] = (1,)


@njit(parallel=True)
def speckle_at(
    points: np.ndarray, places: np.ndarray, heights: np.ndarray, speckle: float
) -> np.ndarray:
    """Blobs of Gaussian shape, squeezed between 0 and 1, at points (N, 2)."""
    grey = np.empty(points.shape[0])
    cells, pitch, spread = places.shape[0], CELL * speckle, WIDTH * speckle
    for k in prange(points.shape[0]):
        x, y = points[k, 0] / pitch, points[k, 1] / pitch
        col, row = int(np.floor(x)), int(np.floor(y))
        total = 0.0
        for j in range(row - 2, row + 3):
            for i in range(col - 2, col + 3):
                r, c = j % cells, i % cells
                dx = (x - i - places[r, c, 0]) * pitch
                dy = (y - j - places[r, c, 1]) * pitch
                away = (dx * dx + dy * dy) / (2 * spread * spread)
                if away < FARTHEST:
                    total += heights[r, c] * np.exp(-away)
        grey[k] = 0.5 + 0.45 * np.tanh(0.65 * total)
    return grey


def take_picture(back: Map, noise: float, seed: int, speckle: float = SPECKLE) -> GreyImage:
    """Photograph the pattern: what `back` finds at each pixel, averaged, in whole levels."""
    rng = np.random.default_rng(5)
    places = rng.random((CELLS, CELLS, 2))
    heights = rng.choice([-1.0, 1.0], (CELLS, CELLS)) * rng.uniform(0.6, 1.2, (CELLS, CELLS))
    rows, cols = np.mgrid[:SIZE, :SIZE].astype(np.float64)
    total = np.zeros(SIZE * SIZE)
    offsets = (np.arange(SUPERSAMPLES) + 0.5) / SUPERSAMPLES - 0.5
    for dy in offsets:
        for dx in offsets:
            pixels = np.stack([cols + dx, rows + dy], axis=-1).reshape(-1, 2)
            total += speckle_at(back(pixels), places, heights, speckle)
    levels = 255 * total / SUPERSAMPLES**2
    levels += np.random.default_rng(seed).normal(0, noise, levels.shape) if noise else 0.0
    grey = np.clip(np.round(levels), 0, 255) / 255
    return GreyImage(grey.reshape(SIZE, SIZE).astype(np.float32), np.ones((SIZE, SIZE), dtype=bool))


def solved(forward: Map, rounds: int = 60) -> Map:
    """Inverse of a map that moves points little, by fixed point."""

    def back(points: np.ndarray) -> np.ndarray:
        guess = points.copy()
        for _ in range(rounds):
            guess = guess + 0.9 * (points - forward(guess))
        return guess

    return back


def translation(amount: float) -> Case:
    shift = np.array([amount, amount])
    return Case(f"translation {amount:.1f}", lambda p: p + shift, lambda p: p - shift)


def linear(name: str, matrix: list[list[float]]) -> Case:
    slope = np.array(matrix)
    inverse = np.linalg.inv(slope)
    return Case(
        name,
        lambda p: (p - CENTRE) @ slope.T + CENTRE,
        lambda p: (p - CENTRE) @ inverse.T + CENTRE,
    )


def sine() -> Case:
    def forward(points: np.ndarray) -> np.ndarray:
        wave = 2.0 * np.sin(2 * np.pi * points / 130.0)
        return points + wave[..., ::-1] * np.array([1.0, 0.0])

    def back(points: np.ndarray) -> np.ndarray:
        wave = 2.0 * np.sin(2 * np.pi * points / 130.0)
        return points - wave[..., ::-1] * np.array([1.0, 0.0])

    return Case("sine 2 px / 130 px", forward, back, (1, 2))


def star() -> Case:
    def forward(points: np.ndarray) -> np.ndarray:
        period = 10.0 + 140.0 * np.clip(points[..., :1], 0, SIZE) / SIZE
        wave = 0.5 * np.cos(2 * np.pi * (points[..., 1:] - SIZE / 2) / period)
        return points + wave * np.array([0.0, 1.0])

    return Case("star 0.5 px, 10-150 px", forward, solved(forward), (1, 2))


def rubber(stretch: float, degrees: float) -> Case:
    """Stretch a rubber sheet along one direction; across, it narrows."""
    angle = np.deg2rad(degrees)
    turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    slope = turned @ np.diag([stretch, stretch**-0.5]) @ turned.T
    return linear(f"rubber {stretch:.1f} along {degrees:.0f} deg", slope.tolist())


def turn(degrees: float, stretch: float) -> Case:
    angle = np.deg2rad(degrees)
    slope = stretch * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return linear(f"turn {degrees:.0f} deg, stretch {stretch:.1f}", slope.tolist())


def slopes_of(forward: Map, points: np.ndarray) -> np.ndarray:
    """(N, 2, 2) gradients of a map."""
    step = 1e-4
    ways = (np.array([step, 0.0]), np.array([0.0, step]))
    sides = [(forward(points + way) - forward(points - way)) / (2 * step) for way in ways]
    return np.stack(sides, axis=-1)


def judged_points(forward: Map, points: np.ndarray, radius: int) -> np.ndarray:
    """Points whose whole warped subset, and the spline around it, stays inside."""
    inside = np.ones(len(points), dtype=bool)
    for dx in (-radius, radius):
        for dy in (-radius, radius):
            corner = forward(points + np.array([dx, dy], dtype=np.float64))
            inside &= ((corner > 2) & (corner < SIZE - 3)).all(axis=1)
    return inside
