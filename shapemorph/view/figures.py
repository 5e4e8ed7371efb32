"""The figures of a run, as files."""

import io
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from shapemorph.core.flattened import FlattenedSurface
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.results import RunResults
from shapemorph.view.maps import (
    correlation_figure,
    distortion_figure,
    surface_distortion_figure,
)
from shapemorph.view.plots import histograms_figure, matches_figure, morph_figure
from shapemorph.view.style import DPI

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Named = Iterator[tuple[str, "Figure"]]


def write_flat_figures(results: RunResults, folder: Path) -> None:
    """Draw all figures of a measurement but those of its shapes; needs no OpenGL.

    Parameters
    ----------
    results : RunResults
    folder : Path
        Made where it is missing.
    """
    write_pictures(encoded(_flat_figures(results)), folder)


def write_planar_figures(grid: CorrelationGrid, reference: GreyImage, folder: Path) -> None:
    """Draw the figures of a correlation of two images; needs no OpenGL."""
    write_pictures(encoded(iter([("correlation", correlation_figure(grid, reference))])), folder)


def write_distortion_figure(name: str, surface: FlattenedSurface, folder: Path) -> None:
    """Draw what the flattening did to one surface, as ``distortion.png``; needs no OpenGL."""
    figure = surface_distortion_figure(name, surface)
    write_pictures(encoded(iter([("distortion", figure)])), folder)


def encoded(figures: Named) -> Iterator[tuple[str, bytes]]:
    """Turn figures into the content of PNG files, each as soon as it is drawn."""
    for name, figure in figures:
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", dpi=DPI, pil_kwargs={"compress_level": 2})
        yield name, buffer.getvalue()


def write_pictures(pictures: Iterable[tuple[str, bytes]], folder: Path) -> None:
    """Write the content of PNG files under their names into a folder, made where missing."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in pictures:
        (folder / f"{name}.png").write_bytes(content)


def _flat_figures(results: RunResults) -> Named:
    """Draw one after the other, so that only one is held at a time."""
    pair, reference = results.pair, results.pair.reference.calibrated.image
    yield "histograms", histograms_figure(results.measurement)
    yield (
        "matches",
        matches_figure(results.matches, reference, pair.deformed.calibrated.image),
    )
    both = reference.mask & results.morphed.image.mask
    yield "morph", morph_figure(reference, results.morphed.image, both)
    yield "correlation", correlation_figure(results.grid, reference)
    yield "flattening", distortion_figure(pair)
