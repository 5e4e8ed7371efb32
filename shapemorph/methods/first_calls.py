"""Loops compiled beside a run, the first time that anything is compiled at all.

Compiling takes one core, and the loops that a correlation calls last can be compiled while it
waits for those that it calls first. A process of its own calls them on a picture of noise;
what it leaves on disk is found when it is needed.
"""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from shapemorph.methods.correlation_checks import find_outliers, neighbour_guesses
from shapemorph.methods.correlation_noise import displacement_covariance
from shapemorph.methods.grid_windows import connected_windows
from shapemorph.methods.rest_motion import unfollowed_motion
from shapemorph.methods.spline_coefficients import CUBIC
from shapemorph.methods.spline_pictures import DeformedPicture, ReferencePicture
from shapemorph.methods.subset_dic import PointGrid, SubsetSettings, grid_points, identity_starts

SIDE, SPACING, WINDOW = 96, 8, 5  # px, px, points: enough to call everything once


@contextmanager
def late_loops_compiled() -> Iterator[None]:
    """Compile the loops of a first order correlation beside the block, if nothing is on disk."""
    import numba

    left_before = next(Path(numba.config.CACHE_DIR).rglob("*.nbi"), None)
    if left_before is not None or numba.config.NUMBA_NUM_THREADS < 2:
        yield
        return
    try:
        beside = subprocess.Popen(
            [sys.executable, "-m", __name__], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
    except OSError:
        yield
        return
    try:
        yield
    finally:
        beside.kill()
        beside.wait()


def call_late_loops() -> None:
    """Call them on noise, in the order in which a correlation would."""
    settings = SubsetSettings(10, 1, 1e-3, 30, 0.5, 10.0, CUBIC)
    grid = grid_points(np.ones((SIDE, SIDE), dtype=bool), spacing=SPACING)
    reference, deformed = _pictures(settings.pad)
    inner = np.zeros_like(grid.inside)
    inner[2:-2, 2:-2] = True
    warps = identity_starts(grid.inside.size).reshape(*grid.inside.shape, 12)
    displacement_covariance(reference, deformed, grid.points, warps, inner, settings=settings)
    unfollowed_motion(reference, deformed, grid.points, warps, inner, radius=settings.radius)
    _ask_neighbours(grid)
    for _windows in connected_windows(inner, window=WINDOW, chunk=SIDE * SIDE):
        pass


def _pictures(pad: int) -> tuple[ReferencePicture, DeformedPicture]:
    """Both sides of a picture of noise."""
    import cv2

    from shapemorph.kernels.vectors import LANES

    shape = (SIDE + 2 * pad, SIDE + 2 * pad + LANES)
    planes = np.random.default_rng(0).random((3, *shape), dtype=np.float32)
    inside = np.ones(shape, np.float32)
    counts = cv2.integral(inside.astype(np.uint8), sdepth=cv2.CV_32S)
    return (
        ReferencePicture(planes, inside, counts, pad, CUBIC),
        DeformedPicture(planes[0].copy(), inside, counts, CUBIC),
    )


def _ask_neighbours(grid: PointGrid) -> None:
    position = grid.points.astype(np.float64)
    gradient = np.broadcast_to(np.eye(2), (*grid.inside.shape, 2, 2)).copy()
    status = np.zeros(grid.inside.shape, np.uint8)
    find_outliers(position, gradient, status, spacing=SPACING, floor=0.15, before=None)
    some = np.argwhere(grid.inside)[:4]
    neighbour_guesses(position, gradient, grid.inside, some, spacing=SPACING)


if __name__ == "__main__":
    call_late_loops()
