"""The figures of a correlation of two pictures."""

from pathlib import Path
from typing import TYPE_CHECKING

from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.planar import PlanarStrain
from shapemorph.view.figures import Named, encoded, write_pictures
from shapemorph.view.layout import Heading
from shapemorph.view.maps import Panel, correlation_figure, grid_extent, panels_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_planar_figures(
    grid: CorrelationGrid,
    strain: PlanarStrain,
    reference: GreyImage,
    folder: Path,
    theme: str = "light",
) -> None:
    """Draw displacement, correlation, strain and uncertainty; needs no OpenGL."""
    write_pictures(encoded(_planar_figures(grid, strain, reference), theme), folder)


def _planar_figures(grid: CorrelationGrid, strain: PlanarStrain, reference: GreyImage) -> Named:
    yield "correlation", correlation_figure(grid, reference)
    yield "strain", strain_figure(grid, strain, reference)
    yield "uncertainty", uncertainty_figure(grid, reference)


def strain_figure(grid: CorrelationGrid, strain: PlanarStrain, reference: GreyImage) -> "Figure":
    """Map the components of Green-Lagrange strain and its larger principal value."""
    extent, green = grid_extent(grid), strain.green
    panels = [
        Panel("Strain along x", green[..., 0, 0], extent, "$E_{xx}$  [–]"),
        Panel("Strain along y", green[..., 1, 1], extent, "$E_{yy}$  [–]"),
        Panel("Shear (tensor)", green[..., 0, 1], extent, "$E_{xy}$  [–]"),
        Panel("Larger principal strain", strain.green_principal[..., 0], extent, "$E_1$  [–]"),
    ]
    note = (
        f"virtual strain gauge {strain.gauge_px:g} px = ({strain.window} points − 1) · "
        f"{grid.spacing} px + subset {grid.subset_size} px"
    )
    return panels_figure(panels, reference, Heading("Green–Lagrange strain", note))


def uncertainty_figure(grid: CorrelationGrid, reference: GreyImage) -> "Figure":
    """Map the random standard deviation of both components of the displacement."""
    extent = grid_extent(grid)
    panels = [
        Panel("Displacement along x", grid.sigma_px[..., 0], extent, "σ(u)  [px]"),
        Panel("Displacement along y", grid.sigma_px[..., 1], extent, "σ(v)  [px]"),
    ]
    note = "one standard deviation of the random part"
    return panels_figure(panels, reference, Heading("Uncertainty of the displacement", note))
