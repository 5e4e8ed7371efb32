"""Flat targets: their points, and where a picture shows them."""

from typing import Any

import numpy as np

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.core.calibration import Target
from shapemorph.core.errors import ConfigError
from shapemorph.methods.cameras.dots import find_dots

_REFINED = 0.3  # of the distance between corners: half the window in which one is refined,
# less where markers are nearer
_WINDOWS = 2, 30  # px
_SETTLED = (3, 100, 1e-5)  # OpenCV: both, steps, px
_LEAST_SHARE = 0.3  # of the corners of a ChArUco board: fewer tell little
_NEAR = 0.25  # of the distance between dots


def grid_target(name: str, columns: int, rows: int, spacing: float, *, dot: float) -> Target:
    """Make a target of points in rows and columns: inner corners of a chessboard, or dots.

    Parameters
    ----------
    name : str
    columns, rows : int
    spacing : float
        mm.
    dot : float
        Diameter of a dot, mm; 0 for corners.
    """
    grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2)
    half_turn = np.arange(len(grid), dtype=np.int64)[::-1].copy()
    alike = dot > 0 or (columns + rows) % 2 == 0
    return Target(
        name,
        _in_plane(grid.astype(np.float64) * spacing),
        dot_radius=dot / 2,
        symmetries=(half_turn,) if alike else (),
    )


def asymmetric_target(name: str, columns: int, rows: int, spacing: float, *, dot: float) -> Target:
    """Make a target whose odd rows of dots are moved by half a step; see :func:`grid_target`."""
    row, column = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    across = (2 * column + row % 2).ravel() * spacing
    points = np.stack([across, row.ravel() * spacing], axis=-1)
    half_turn = np.arange(len(points), dtype=np.int64)[::-1].copy()
    return Target(
        name,
        _in_plane(points),
        dot_radius=dot / 2,
        symmetries=(half_turn,) if rows % 2 else (),
    )


def charuco_board(columns: int, rows: int, spacing: float, marker: float, dictionary: str) -> Any:
    """Make OpenCV's description of a ChArUco board.

    Raises
    ------
    ConfigError
        If there is no such dictionary, or markers do not fit into squares.
    """
    import cv2

    number = getattr(cv2.aruco, dictionary, None)
    if number is None:
        known = ", ".join(name for name in dir(cv2.aruco) if name.startswith("DICT_4X4"))
        raise ConfigError(f"dictionary {dictionary!r} is unknown: expected {known}, ...")
    if marker >= spacing:
        raise ConfigError(f"a marker of {marker:g} mm does not fit into a square of {spacing:g} mm")
    markers = cv2.aruco.getPredefinedDictionary(number)
    return cv2.aruco.CharucoBoard((columns, rows), spacing, marker, markers)


def charuco_target(name: str, board: Any) -> Target:
    """Make the target of the inner corners of a ChArUco board."""
    return Target(name, _in_plane(np.asarray(board.getChessboardCorners())[:, :2]))


def _in_plane(points: Floats) -> Floats:
    return np.column_stack([points, np.zeros(len(points))]).astype(np.float64)


def find_chessboard(grey: Greys, columns: int, rows: int) -> Floats | None:
    """Find the inner corners (rows * columns, 2) of a chessboard; None if it is not there whole."""
    import cv2

    picture = _eight_bit(grey)
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
    found, corners = cv2.findChessboardCorners(picture, (columns, rows), flags=flags)
    if not found:
        flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_EXHAUSTIVE
        found, corners = cv2.findChessboardCornersSB(picture, (columns, rows), flags=flags)
    if not found:
        return None
    grid = np.asarray(corners, dtype=np.float32).reshape(rows, columns, 2)
    return _refined(picture, grid.reshape(-1, 2), _least_step(grid))


def find_charuco(grey: Greys, board: Any) -> tuple[Ints, Floats] | None:
    """Find inner corners of a ChArUco board, by their numbers; None if there are too few."""
    import cv2

    picture = _eight_bit(grey)
    corners, ids, _, _ = cv2.aruco.CharucoDetector(board).detectBoard(picture)
    columns, rows = board.getChessboardSize()
    if ids is None or len(ids) < max(_LEAST_SHARE * (columns - 1) * (rows - 1), 6):
        return None
    pixels = np.asarray(corners, dtype=np.float32).reshape(-1, 2)
    numbers = np.asarray(ids).ravel().astype(np.int64)
    known = np.asarray(board.getChessboardCorners())[numbers, :2]
    gaps = np.linalg.norm(known[:, None] - known[None], axis=-1) + 1e9 * np.eye(len(known))
    nearest = gaps.argmin(axis=1)
    step = float(np.linalg.norm(pixels - pixels[nearest], axis=1).min())
    margin = (1 - board.getMarkerLength() / board.getSquareLength()) / 2
    return numbers, _refined(picture, pixels, step, min(_REFINED, margin))


def find_dot_grid(
    grey: Greys, columns: int, rows: int, *, asymmetric: bool, dark: bool
) -> Floats | None:
    """Find the dots (rows * columns, 2) of a flat grid; None if it is not there whole."""
    import cv2
    from scipy.spatial import cKDTree

    flags = cv2.CALIB_CB_ASYMMETRIC_GRID if asymmetric else cv2.CALIB_CB_SYMMETRIC_GRID
    spots = find_dots(grey, dark=dark)
    if len(spots.centres) < columns * rows:
        return None
    found, centres = cv2.findCirclesGrid(
        spots.centres.astype(np.float32).reshape(-1, 1, 2),
        (columns, rows),
        flags=flags | cv2.CALIB_CB_CLUSTERING,
        blobDetector=None,
        parameters=cv2.CirclesGridFinderParameters(),
    )
    if not found:
        return None
    pixels = np.asarray(centres, dtype=np.float64).reshape(-1, 2)
    gaps, nearest = cKDTree(spots.centres).query(pixels)
    step = _least_step(pixels.reshape(rows, columns, 2))
    return spots.centres[nearest] if np.max(gaps) < _NEAR * step else None


def _eight_bit(grey: Greys) -> "np.ndarray[tuple[int, ...], np.dtype[np.uint8]]":
    return np.round(255 * np.clip(grey, 0, 1)).astype(np.uint8)


def _least_step(grid: "Floats | Greys") -> float:
    """Shortest distance between neighbours of a grid (R, C, 2), px."""
    return min(float(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min()) for axis in (0, 1))


def _refined(
    picture: "np.ndarray[tuple[int, ...], np.dtype[np.uint8]]",
    corners: Greys,
    step: float,
    reach: float = _REFINED,
) -> Floats:
    """Move corners to where the gradients about them cross."""
    import cv2

    half = int(np.clip(reach * step, *_WINDOWS))
    points = np.ascontiguousarray(corners.reshape(-1, 1, 2))
    moved = cv2.cornerSubPix(picture, points, (half, half), (-1, -1), _SETTLED)
    return np.asarray(moved, dtype=np.float64).reshape(-1, 2)
