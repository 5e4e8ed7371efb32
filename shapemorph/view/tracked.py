"""The figures of what two cameras saw over time."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.measurement import Measurement
from shapemorph.view.figures import Named, encoded, histogram_figures, write_pictures
from shapemorph.view.layout import Heading
from shapemorph.view.maps import Panel, correlation_figure, grid_extent, panels_figure
from shapemorph.view.measures import MEASURES, measure_values

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_tracked_figures(
    measurement: Measurement,
    grid: CorrelationGrid,
    first: GreyImage,
    folder: Path,
    theme: str = "light",
) -> None:
    """Draw fields, matches and histograms of the last state; needs no OpenGL.

    Parameters
    ----------
    measurement : Measurement
        Of the points of the grid.
    grid : CorrelationGrid
        First left picture -> last left picture.
    first : GreyImage
        First left picture, with the mask of what is measured.
    folder : Path
    theme : str
    """
    write_pictures(encoded(_tracked_figures(measurement, grid, first), theme), folder)


def _tracked_figures(measurement: Measurement, grid: CorrelationGrid, first: GreyImage) -> Named:
    yield "fields", fields_figure(measurement, grid, first)
    yield "correlation", correlation_figure(grid, first)
    yield from histogram_figures(measurement)


def fields_figure(measurement: Measurement, grid: CorrelationGrid, first: GreyImage) -> "Figure":
    """Map displacement and principal strains over the first left picture."""
    assert measurement.grid_index is not None
    extent, panels = grid_extent(grid), []
    for measure in MEASURES:
        values = np.full(grid.status.size, np.nan)
        values[measurement.grid_index] = measure_values(measurement, measure)
        field = values.reshape(grid.status.shape)
        panels.append(Panel(measure.title, field, extent, measure.label))
    note = "of the last state, where its points lay in the first left picture"
    return panels_figure(panels, first, Heading("Displacement and strain", note))
