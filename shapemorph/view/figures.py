"""The figures of a run, as files."""

from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

from shapemorph.core.flattened import FlattenedPair, FlattenedSurface
from shapemorph.core.forming import Forming
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.laws import LawSpread
from shapemorph.core.matching import Matches
from shapemorph.core.measurement import Measurement
from shapemorph.core.morphed import Morphed
from shapemorph.core.results import RunResults
from shapemorph.view.captions import SECTION
from shapemorph.view.maps import (
    correlation_figure,
    distortion_figure,
    surface_distortion_figure,
)
from shapemorph.view.plots import histograms_figure, matches_figure, morph_figure
from shapemorph.view.theme import THEMES, drawn, png

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Named = Iterator[tuple[str, "Figure"]]


def write_distortion_figure(
    name: str, surface: FlattenedSurface, folder: Path, theme: str = "light"
) -> None:
    """Draw what the flattening did to one surface, as ``distortion.png``; needs no OpenGL."""
    figure = surface_distortion_figure(name, surface)
    write_pictures(encoded(iter([("distortion", figure)]), theme), folder)


def encoded(figures: Named, theme: str = "light") -> Iterator[tuple[str, bytes]]:
    """Turn figures into the content of PNG files; one is compressed while the next is drawn."""
    with ThreadPoolExecutor(1) as pool:
        before: tuple[str, Future[bytes]] | None = None
        for name, figure in figures:
            pixels = drawn(figure, THEMES[theme])
            if before:
                yield before[0], before[1].result()
            before = name, pool.submit(png, pixels, THEMES[theme])
        if before:
            yield before[0], before[1].result()


def write_pictures(pictures: Iterable[tuple[str, bytes]], folder: Path) -> None:
    """Write the content of PNG files under their names into a folder, made where missing."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in pictures:
        (folder / f"{name}.png").write_bytes(content)


def flattening_figures(pair: FlattenedPair) -> Named:
    """Draw what the flattening of both shapes did."""
    yield "flattening", distortion_figure(pair)


def matching_figures(reference: GreyImage, deformed: GreyImage, matches: Matches) -> Named:
    """Draw what was matched."""
    yield "matches", matches_figure(matches, reference, deformed)


def morph_figures(reference: GreyImage, morphed: Morphed) -> Named:
    """Draw the morphed picture beside the reference."""
    yield "morph", morph_figure(reference, morphed.image, reference.mask & morphed.image.mask)


def correlation_figures(reference: GreyImage, grid: CorrelationGrid) -> Named:
    """Draw the field that the correlation found."""
    yield "correlation", correlation_figure(grid, reference)


def histogram_figures(measurement: Measurement) -> Named:
    """Draw how status, ZNCC and strain are spread over the points."""
    yield "histograms", histograms_figure(measurement)


def forming_figures(measurement: Measurement, forming: Forming) -> Named:
    """Draw the forming-limit diagram and the sections that were asked for."""
    from shapemorph.view.forming import limit_figure, section_figure

    if forming.diagram:
        yield "forming_limits", limit_figure(measurement, forming)
    for cut in forming.cuts:
        yield f"{SECTION}{cut.name}", section_figure(measurement, cut)


def law_figures(results: RunResults, spread: LawSpread) -> Named:
    """Draw the morph laws of a run beside the one that was found."""
    from shapemorph.view.laws import laws_figure  # with it comes numba: half a second

    yield "morph_laws", laws_figure(results, spread)
