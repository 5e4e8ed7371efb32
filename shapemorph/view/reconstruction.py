"""Maps of a surface that two cameras saw, over the picture of the first."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.image import GreyImage
from shapemorph.core.reconstruction import Reconstruction
from shapemorph.core.status import PointStatus
from shapemorph.view.figures import Named, encoded, write_pictures
from shapemorph.view.layout import Heading
from shapemorph.view.maps import Panel, panels_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_reconstruction_figures(found: Reconstruction, first: GreyImage, folder: Path) -> None:
    """Draw ``reconstruction.png``; needs no OpenGL."""
    write_pictures(encoded(_figures(found, first)), folder)


def _figures(found: Reconstruction, first: GreyImage) -> Named:
    yield "reconstruction", reconstruction_figure(found, first)


def reconstruction_figure(found: Reconstruction, first: GreyImage) -> "Figure":
    """Map distance, uncertainty, epipolar error and correlation."""
    ok = found.status == PointStatus.OK
    low, high = found.first_px.reshape(-1, 2).min(axis=0), found.first_px.reshape(-1, 2).max(axis=0)
    half = found.spacing / 2
    extent = (low[0] - half, high[0] + half, high[1] + half, low[1] - half)
    panels = [
        Panel("Distance from the first camera", found.points[..., 2], extent, "z  [mm]"),
        Panel("Uncertainty of the distance", found.sigma[..., 2], extent, "σ(z)  [mm]"),
        Panel(
            "Off the epipolar line",
            np.where(ok, found.epipolar_px, np.nan),
            extent,
            "epipolar error  [px]",
        ),
        Panel("Correlation", np.where(ok, found.zncc, np.nan), extent, "ZNCC  [–]"),
    ]
    note = f"{int(ok.sum())} points over the picture of {found.rig.names[0]}"
    return panels_figure(panels, first, Heading("Reconstruction", note))
