"""Stage `calibrate`: pictures of targets to calibrated cameras."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from shapemorph.config import CalibrateConfig, TargetConfig
from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.core.calibration import Calibration, Sighting, Target, View
from shapemorph.core.errors import DataError
from shapemorph.methods.cameras.boards import (
    asymmetric_target,
    charuco_board,
    charuco_target,
    find_charuco,
    find_chessboard,
    find_dot_grid,
    grid_target,
)
from shapemorph.methods.cameras.bundle import free_lens
from shapemorph.methods.cameras.calibration import calibrate_rig
from shapemorph.methods.cameras.dot_names import Anchor, identify
from shapemorph.methods.cameras.dots import find_dots

_AS_ROUND = 2 / np.sqrt(3)  # diameter of a disc with the second moments of a unit square


@dataclass(frozen=True, slots=True, eq=False)
class Finder:
    """A target and how it is found.

    Attributes
    ----------
    target : Target
    config : TargetConfig
    board : object or None
        OpenCV's description of a ChArUco board.
    """

    target: Target
    config: TargetConfig
    board: Any = None


def make_finder(name: str, config: TargetConfig, points: Target | None) -> Finder:
    """Prepare to find one target of the configuration.

    Parameters
    ----------
    name : str
    config : TargetConfig
    points : Target or None
        What the file of kind `points` holds.

    Raises
    ------
    ConfigError
        If the target cannot be as described.
    """
    if config.kind == "points":
        if points is None:
            raise DataError(f"target {name}: expected its points")
        shape = _AS_ROUND if config.dot_shape == "square" else 1.0
        radius = shape * config.dot_diameter / 2
        return Finder(replace(points, name=name, dot_radius=radius), config)
    columns, rows, spacing = config.columns or 0, config.rows or 0, config.spacing or 0.0
    if config.kind == "charuco":
        board = charuco_board(columns, rows, spacing, config.marker or 0.0, config.dictionary)
        return Finder(charuco_target(name, board), config, board)
    if config.kind == "asymmetric_dots":
        dot = config.dot_diameter
        return Finder(asymmetric_target(name, columns, rows, spacing, dot=dot), config)
    dot = config.dot_diameter if config.kind == "dots" else 0.0
    return Finder(grid_target(name, columns, rows, spacing, dot=dot), config)


def find_target(
    grey: Greys, finder: Finder, anchors: Sequence[tuple[int, int, float, float]]
) -> tuple[Ints, Floats]:
    """Find a target in a picture: numbers of its points, and their pixels.

    Parameters
    ----------
    grey : (H, W)
        In [0, 1].
    finder : Finder
    anchors : sequence of (row, column, x, y)
        Dots whose place is known roughly.

    Raises
    ------
    DataError
        If it is not there, saying what was looked for.
    """
    config = finder.config
    if config.kind == "points":
        named = [_anchor(finder.target, anchor) for anchor in anchors]
        spots = find_dots(grey, dark=config.dark, least_px=config.least_px)
        return identify(finder.target, spots, named)
    if config.kind == "charuco":
        found = find_charuco(grey, finder.board)
        if found is None:
            raise DataError(f"no ChArUco board of {config.columns} x {config.rows} squares found")
        return found
    pixels = _whole_grid(grey, config)
    if pixels is None:
        what = "inner corners" if config.kind == "chessboard" else "dots"
        raise DataError(
            f"no {config.kind.replace('_', ' ')} of {config.columns} x {config.rows} {what} found"
        )
    return np.arange(len(pixels), dtype=np.int64), pixels


def _whole_grid(grey: Greys, config: TargetConfig) -> Floats | None:
    columns, rows = config.columns or 0, config.rows or 0
    if config.kind == "chessboard":
        return find_chessboard(grey, columns, rows)
    asymmetric = config.kind == "asymmetric_dots"
    return find_dot_grid(grey, columns, rows, asymmetric=asymmetric, dark=config.dark)


def _anchor(target: Target, given: tuple[int, int, float, float]) -> Anchor:
    row, column, x, y = given
    if target.lattice is None:
        raise DataError("anchors are for targets with rows and columns")
    at = np.flatnonzero((target.lattice == (row, column)).all(axis=1))
    if not len(at):
        raise DataError(f"anchor: the target has no point in row {row}, column {column}")
    return Anchor(int(at[0]), np.array([x, y]))


def calibrate(
    sightings: Sequence[Sighting],
    views: Sequence[View],
    sizes: Sequence[tuple[int, int]],
    names: Sequence[str],
    rejected: Sequence[tuple[str, str]],
    config: CalibrateConfig,
) -> Calibration:
    """Calibrate all cameras together.

    Parameters
    ----------
    sightings : sequence of Sighting
    views : sequence of View
    sizes : sequence of (int, int)
        Width and height of the pictures of each camera, px.
    names : sequence of str
        Of the cameras.
    rejected : sequence of (str, str)
        Pictures without the target, and why.
    config : CalibrateConfig
        Section ``calibrate``.

    Raises
    ------
    DataError, StageError
        See :func:`~shapemorph.methods.cameras.calibration.calibrate_rig`.
    """
    lens = free_lens(radial=config.radial, tangential=config.tangential, skew=config.skew)
    return calibrate_rig(sightings, views, sizes, names=names, lens=lens, rejected=rejected)
