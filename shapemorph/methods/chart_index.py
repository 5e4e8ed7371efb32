"""A chart with its triangles sorted into buckets, to be looked up by place."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.image import Chart
from shapemorph.kernels import locate as locate_kernel
from shapemorph.methods.distortion import chart_handedness

TRIANGLES_PER_CELL = 1.0
ROUND_OFF = 64 * np.finfo(np.float64).eps


@dataclass(frozen=True, slots=True, eq=False)
class ChartIndex:
    """A chart with its triangles sorted into a grid of buckets.

    Attributes
    ----------
    px, faces, sign, grid, cols, starts, items
        Arguments of :func:`shapemorph.kernels.locate.locate`.
    """

    px: Floats
    faces: Ints
    sign: float
    grid: Floats
    cols: int
    starts: Ints
    items: Ints

    @property
    def arguments(self) -> tuple[Floats, Ints, float, Floats, int, Ints, Ints]:
        """What the kernels ask for, in their order."""
        return (self.px, self.faces, self.sign, self.grid, self.cols, self.starts, self.items)


def index_chart(chart: Chart) -> ChartIndex:
    """Sort the triangles of a chart into buckets of a few each.

    Triangles that lie upside down are left out. Points that round-off carries over the
    border (64 units in the last place of the largest coordinate) still count as inside.
    """
    low, high = chart.vertex_px.min(axis=0), chart.vertex_px.max(axis=0)
    extent = high - low
    cells = max(len(chart.faces) / TRIANGLES_PER_CELL, 1.0)
    size = max(float(np.sqrt(extent.prod() / cells)), float(extent.max()) / 8192, 1e-300)
    cols, rows = (np.floor(extent / size).astype(int) + 1).tolist()
    slack = ROUND_OFF * float(np.abs(chart.vertex_px).max())
    px, faces = np.ascontiguousarray(chart.vertex_px), np.ascontiguousarray(chart.faces)
    sign, grid = chart_handedness(chart), np.array([low[0], low[1], size, slack])
    starts, items = locate_kernel.fill_buckets(px, faces, sign, grid, rows, cols)
    return ChartIndex(px, faces, sign, grid, cols, starts, items)
