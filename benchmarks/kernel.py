"""Print speed and accuracy of the correlation kernel on speckle that is known exactly.

    python benchmarks/kernel.py                 all cases, subset 21, spacing 8
    python benchmarks/kernel.py --quick         fewer cases
    python benchmarks/kernel.py --subset 31

An analytic speckle, 4.5 px wide where its autocorrelation is one half, 1000 x 1000 px, 4 x 4
supersampled, 8 bit. Points start from the exact displacement rounded to a pixel; timed are
Hessians and all iterations, best of several runs, OK points counted. Errors are those of both
components together over points whose whole warped subset stays inside the deformed picture;
right is within 0.1 px.
"""

import argparse
import datetime as dt
import platform
from collections.abc import Callable
from dataclasses import dataclass

import numba
import numpy as np
from numba import njit, prange

from shapemorph.core.image import GreyImage
from shapemorph.core.status import PointStatus
from shapemorph.methods.spline_pictures import prepare_deformed, prepare_reference
from shapemorph.methods.subset_dic import (
    SubsetMatches,
    SubsetSettings,
    affine_starts,
    identity_starts,
    match_points,
)
from shapemorph.methods.threads import kernel_threads

SIZE, SPACING, SUPERSAMPLES = 1000, 8, 4
CELL = 0.73  # distance of the blobs of the pattern, one in each cell, in speckles
WIDTH = 0.3  # standard deviation of a blob, in speckles
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
                total += heights[r, c] * np.exp(-(dx * dx + dy * dy) / (2 * spread * spread))
        grey[k] = 0.5 + 0.4 * np.tanh(total)
    return grey


def take_picture(back: Map, noise: float, seed: int, speckle: float) -> GreyImage:
    """Photograph the pattern: what `back` finds at each pixel, averaged, in whole levels."""
    rng = np.random.default_rng(5)
    places = rng.random((256, 256, 2))
    heights = rng.choice([-1.0, 1.0], (256, 256)) * rng.uniform(0.6, 1.2, (256, 256))
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


def turn(degrees: float, stretch: float) -> Case:
    angle = np.deg2rad(degrees)
    slope = stretch * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return linear(f"turn {degrees:.0f} deg, stretch {stretch:.1f}", slope.tolist())


def all_cases(*, quick: bool) -> list[Case]:
    """Build the cases of the table."""
    shifts = (0.3, 0.5) if quick else tuple(k / 10 for k in range(1, 10))
    cases = [translation(amount) for amount in shifts]
    cases.append(linear("affine 2 %", [[1.02, 0.01], [-0.01, 0.985]]))
    if not quick:
        cases += [sine(), star(), turn(0, 1.3), turn(25, 1.0), turn(90, 1.0)]
    return cases


def slopes_of(forward: Map, points: np.ndarray) -> np.ndarray:
    """(N, 2, 2) gradients of a map."""
    step = 1e-4
    ways = (np.array([step, 0.0]), np.array([0.0, step]))
    sides = [(forward(points + way) - forward(points - way)) / (2 * step) for way in ways]
    return np.stack(sides, axis=-1)


def starts_for(case: Case, points: np.ndarray) -> np.ndarray:
    """Whole-pixel starts; with the gradient rounded to 0.05 where it is far from one."""
    where = points + np.round(case.forward(points.astype(np.float64)) - points)
    slopes = slopes_of(case.forward, points.astype(np.float64))
    if np.abs(slopes - np.eye(2)).max() < 0.15:
        starts = identity_starts(len(points))
        starts[:, [0, 6]] = where - points
        return starts
    return affine_starts(points, where, np.round(slopes / 0.05) * 0.05)


def judged_points(case: Case, points: np.ndarray, radius: int) -> np.ndarray:
    """Points whose whole warped subset, and the spline around it, stays inside."""
    inside = np.ones(len(points), dtype=bool)
    for dx in (-radius, radius):
        for dy in (-radius, radius):
            corner = case.forward(points + np.array([dx, dy], dtype=np.float64))
            inside &= ((corner > 2) & (corner < SIZE - 3)).all(axis=1)
    return inside


def run_case(case: Case, noise: float, options: argparse.Namespace) -> None:
    """Print one line for each order and number of threads."""
    radius = options.subset // 2
    axis = np.arange(3 * SPACING, SIZE - 3 * SPACING, SPACING)
    points = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    points = points[judged_points(case, points, radius)]
    truth = case.forward(points.astype(np.float64))
    first = take_picture(lambda p: p, noise, 11, options.speckle)
    second = take_picture(case.back, noise, 12, options.speckle)
    for order in case.orders:
        settings = SubsetSettings(radius, order, 1e-3, 30, 0.5, float(radius))
        reference = prepare_reference(first, allowed=None, pad=settings.pad)
        deformed = prepare_deformed(second, pad=settings.pad)
        starts = starts_for(case, points)
        speeds = []
        for threads in (1, 2):
            with kernel_threads(threads):
                runs = [
                    match_points(reference, deformed, points, starts, settings=settings)
                    for _ in range(options.repeats)
                ]
            best = min(run.seconds for run in runs)
            speeds.append((runs[0].status == PointStatus.OK).sum() / best)
        print_line(case.name, noise, order, runs[0], truth, speeds)


def print_line(
    name: str,
    noise: float,
    order: int,
    found: SubsetMatches,
    truth: np.ndarray,
    speeds: list[float],
) -> None:
    ok = found.status == PointStatus.OK
    error = (found.position - truth)[ok]
    far = np.abs(error).max(axis=1)
    near = error[far < 0.1]
    rms = 1e3 * np.sqrt((near**2).mean()) if len(near) else np.nan
    bias = 1e3 * np.abs(near.mean(axis=0)).max() if len(near) else np.nan
    print(
        f"{name:28s} {noise:5.0f} {order:5d} {speeds[0] / 1e3:8.0f} {speeds[1] / 1e3:8.0f} "
        f"{found.iterations[ok].mean():6.2f} {rms:8.2f} {bias:8.2f} "
        f"{100 * (far < 0.1).sum() / len(ok):8.2f} {100 * (far >= 0.1).sum() / len(ok):8.2f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer cases")
    parser.add_argument("--subset", type=int, default=21, help="width of a subset, odd, px")
    parser.add_argument("--speckle", type=float, default=4.5, help="size of a speckle, px")
    parser.add_argument("--repeats", type=int, default=7, help="runs, of which the best counts")
    options = parser.parse_args()
    today = dt.datetime.now(tz=dt.UTC).date().isoformat()
    print(f"{today}, {platform.machine()}, {numba.config.NUMBA_NUM_THREADS} cores; ", end="")
    print(f"subset {options.subset} px, spacing {SPACING} px, speckle {options.speckle} px")
    print(f"{'case':28s} noise order   k/s 1T   k/s 2T  iter.  RMS mpx bias mpx   right %  wrong %")
    for case in all_cases(quick=options.quick):
        for noise in (0.0, 2.0):
            run_case(case, noise, options)


if __name__ == "__main__":
    main()
