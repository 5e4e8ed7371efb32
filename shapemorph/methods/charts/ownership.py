"""Which of several overlapping charts a measured point is taken from."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.flattened import FlattenedPair
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import CalibratedImage
from shapemorph.core.status import PointStatus
from shapemorph.core.surface import TrackedSurface
from shapemorph.methods.charts.mosaic import page_of

NEAR = 0.85  # spacings: a point of a regular grid is nowhere farther than 0.71 away


@dataclass(frozen=True, slots=True, eq=False)
class Ownership:
    """Pages of the points of a grid.

    Attributes
    ----------
    page : (R, C) int64
    owned : (R, C) bool
        Points that stand for their piece of surface; the others repeat it.
    reference_left, deformed_left : (R, C) float64
        First column of the page of each point in the two pictures, px.
    """

    page: Ints
    owned: Bools
    reference_left: Floats
    deformed_left: Floats


def one_page(shape: tuple[int, ...]) -> Ownership:
    """Give all points (R, C) to the one page that there is."""
    left = np.zeros(shape)
    return Ownership(np.zeros(shape, dtype=np.int64), np.ones(shape, dtype=np.bool_), left, left)


def assign_points(pair: FlattenedPair, grid: CorrelationGrid, tracked: TrackedSurface) -> Ownership:
    """Give every piece of surface to one page.

    Where charts overlap, that counts which is the home of a face; a point that was lost
    there is taken from the other.

    Parameters
    ----------
    pair : FlattenedPair
    grid : CorrelationGrid
    tracked : TrackedSurface
    """
    reference, deformed = pair.reference.calibrated, pair.deformed.calibrated
    page = page_of(reference.chart, grid.reference_px)
    owned = np.ones(page.shape, dtype=bool)
    if reference.chart.home is not None:
        owned = _at_home(reference, grid, reference.chart.home)
        owned |= _only_here(tracked, owned)
    return Ownership(
        page,
        owned,
        reference.chart.page_starts[page].astype(np.float64),
        deformed.chart.page_starts[page.clip(0, deformed.chart.page_count - 1)].astype(np.float64),
    )


def _at_home(image: CalibratedImage, grid: CorrelationGrid, home: Bools) -> Bools:
    height, width = image.image.shape
    columns, rows = (grid.reference_px[..., axis].round().astype(int) for axis in (0, 1))
    triangle = image.triangle[rows.clip(0, height - 1), columns.clip(0, width - 1)]
    at_home: Bools = (triangle < 0) | home[triangle]
    return at_home


def _only_here(tracked: TrackedSurface, owned: Bools) -> Bools:
    """OK points away from home near which no point at home is OK."""
    from scipy.spatial import cKDTree

    ok = tracked.status == PointStatus.OK
    away, at_home = ok & ~owned, ok & owned
    alone = np.zeros(owned.shape, dtype=bool)
    if away.any() and at_home.any():
        distance, near = cKDTree(tracked.reference[at_home]).query(tracked.reference[away])
        alone[away] = distance > NEAR * _spacing(tracked.reference)[at_home][near]
    return alone


def _spacing(points: Floats) -> Floats:
    """(R, C) distance to the farther of the two next points along rows and columns, mm."""
    steps = []
    for axis in (0, 1):
        step = np.linalg.norm(np.diff(points, axis=axis), axis=-1)
        pad = [(0, 0), (0, 0)]
        pad[axis] = (1, 0)
        before = np.pad(step, pad, constant_values=np.nan)
        pad[axis] = (0, 1)
        steps += [before, np.pad(step, pad, constant_values=np.nan)]
    known = np.nan_to_num(np.stack(steps), nan=0.0)
    farther: Floats = known.max(axis=0)
    return farther
