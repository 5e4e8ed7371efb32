"""Print a table of matching on flat pictures whose map is known exactly.

Run: python -m benchmarks.matching   (or: python benchmarks/matching.py)

Noise of 2 grey levels, contrast 0.85, light that changes by 20 % across the picture.
Right: off by less than 2 px of the deformed picture. Gap: farthest that a point seen in
both pictures lies from a right pair. Warp: error of the forward warp wherever both
pictures show the specimen. Seconds are of the second of two runs.
"""

import time
from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from shapemorph.config import MatchConfig
from shapemorph.core.errors import StageError
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Matches
from shapemorph.methods.synthetic.planar import (
    Exposure,
    inverse_at,
    planar_speckle,
    take_picture,
)
from shapemorph.methods.warping import warp_points
from shapemorph.stages.match import match

BEFORE = Exposure(gain=1.0, offset=0.0, slope=0.0, noise=2.0, seed=1)
AFTER = Exposure(gain=0.85, offset=0.02, slope=0.2, noise=2.0, seed=2)
Map = Callable[[np.ndarray], np.ndarray]


def rotation(degrees: float) -> np.ndarray:
    angle = np.deg2rad(degrees)
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def linear(matrix: np.ndarray, size: int, shape: tuple[int, int]) -> Map:
    """The middle of the specimen is seen in the middle of the picture."""
    back, middle = np.linalg.inv(matrix), np.array(shape[::-1]) / 2
    return lambda points: (points - middle) @ back.T + size / 2


def bulge(amount: float, size: int, shape: tuple[int, int]) -> Map:
    middle = np.array(shape[::-1]) / 2

    def material_at(points: np.ndarray) -> np.ndarray:
        offset = points - middle
        square = (offset**2).sum(-1, keepdims=True) / (size / 2) ** 2
        return size / 2 + offset / (1 + amount * np.exp(-2 * square))

    return material_at


def kink(inner: float, outer: float, size: int, shape: tuple[int, int]) -> Map:
    """Stretch `inner` inside half of the radius, `outer` beyond it."""
    middle, edge = np.array(shape[::-1]) / 2, size / 4

    def material_at(points: np.ndarray) -> np.ndarray:
        offset = points - middle
        radius = np.linalg.norm(offset, axis=-1, keepdims=True) + 1e-9
        near = np.minimum(radius / inner, edge)
        return size / 2 + offset / radius * (near + np.maximum(radius - edge * inner, 0) / outer)

    return material_at


def disc(size: int) -> Callable[[np.ndarray], np.ndarray]:
    return lambda points: np.linalg.norm(points - size / 2, axis=-1) < 0.48 * size


def uniaxial(stretch: float, turn: float, size: int) -> tuple[Map, tuple[int, int]]:
    matrix = rotation(turn) @ np.diag([stretch, stretch**-0.5]) @ rotation(10).T
    reach = np.ceil(np.abs(matrix) @ np.full(2, size / 2)).astype(int)
    shape = (int(2 * reach[1] + 40), int(2 * reach[0] + 40))
    return linear(matrix, size, shape), shape


def cases() -> list[tuple[str, Map, int, tuple[int, int], float]]:
    """Name, pixel -> material, size of the specimen, shape of the picture, speckle diameter."""
    table: list[tuple[str, Map, int, tuple[int, int], float]] = []
    for degrees in (0.0, 45.0, 163.0, 270.0):
        matrix, shape = 1.2 * rotation(degrees), (700, 720)
        table.append((f"turned by {degrees:.0f}, 1.2 x", linear(matrix, 500, shape), 500, shape, 5))
    for diameter in (2.5, 5.0, 8.0, 12.0, 20.0):
        shape = (620, 640)
        table.append(
            (f"bulge 2 x, speckle {diameter:g}", bulge(1.0, 500, shape), 500, shape, diameter)
        )
    for inner, outer in ((1.5, 1.0), (2.0, 1.2)):
        shape = (820, 840)
        table.append(
            (f"kink {inner:g} to {outer:g}", kink(inner, outer, 500, shape), 500, shape, 5)
        )
    for stretch in (2.0, 3.0, 3.5, 5.0):
        material_at, shape = uniaxial(stretch, 20.0, 500)
        table.append((f"uniaxial {stretch:g}", material_at, 500, shape, 5))
    for scale in (0.4, 3.0):
        shape = (int(520 * scale * 1.4), int(530 * scale * 1.4))
        matrix = scale * rotation(30)
        diameter = 5 * max(1, 1 / scale)
        table.append((f"scale {scale:g}", linear(matrix, 500, shape), 500, shape, diameter))
    table.append(("bulge, 1 Mpx", bulge(0.3, 1000, (1000, 1000)), 1000, (1000, 1000), 5))
    return table


def judge(matches: Matches, material_at: Map, before: GreyImage, after: GreyImage) -> str:
    rows, cols = np.nonzero(before.mask[::5, ::5])
    points = 5.0 * np.column_stack([cols, rows])
    claimed = warp_points(matches.forward, points)[0]
    true = inverse_at(material_at, points, claimed)
    seen = ((true > 0) & (true < np.array(after.shape[::-1]) - 1)).all(axis=1)
    exact = inverse_at(material_at, matches.reference_px, matches.deformed_px)
    pairs = np.linalg.norm(exact - matches.deformed_px, axis=1)
    warp = np.linalg.norm(claimed - true, axis=1)[seen]
    gap = cKDTree(matches.reference_px[pairs < 2]).query(points[seen])[0].max()
    return (
        f"{(pairs < 2).sum():5d}/{len(pairs):<5d} {np.median(pairs):7.3f} {pairs.max():7.2f} "
        f"{np.median(warp):7.3f} {np.percentile(warp, 99):7.2f} {warp.max():7.2f} {gap:6.1f} "
        f"{matches.residual_px:7.3f} {matches.settled_px:8.3f} {matches.counts['matched']:8d} "
        f"{matches.counts['voted']:6d}"
    )


def main() -> None:
    print(f"{'case':24s} {'right':>11s} {'pairs':>7s} {'max':>7s} {'warp':>7s} {'p99':>7s} "
          f"{'max':>7s} {'gap':>6s} {'own':>7s} {'settled':>8s} {'matched':>8s} {'voted':>6s} "
          f"{'s':>6s}")  # fmt: skip
    for name, material_at, size, shape, diameter in cases():
        speckle = planar_speckle(diameter=diameter, seed=3)
        before = take_picture(
            speckle, (size, size), BEFORE, material_at=lambda p: p, inside=disc(size)
        )
        after = take_picture(speckle, shape, AFTER, material_at=material_at, inside=disc(size))
        try:
            match(before, after, MatchConfig())
            start = time.perf_counter()
            matches = match(before, after, MatchConfig())
            seconds = time.perf_counter() - start
        except StageError as error:
            print(f"{name:24s} {error}", flush=True)
            continue
        row = judge(matches, material_at, before, after)
        print(f"{name:24s} {row} {seconds:6.2f}", flush=True)


if __name__ == "__main__":
    main()
