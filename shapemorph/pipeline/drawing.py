"""Which figures show which stages, and asking for each as soon as it can be drawn."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from shapemorph.core.flattened import FlattenedPair
from shapemorph.core.image import GreyImage
from shapemorph.core.results import RunResults
from shapemorph.pipeline.run import Results

if TYPE_CHECKING:
    from shapemorph.view.drawing_process import DrawingProcess, Pictures
    from shapemorph.view.figures import Named

    _Job = tuple[Callable[..., None], Callable[..., Named], Callable[[], tuple[object, ...]]]


class Drawing:
    """The figures of a run, drawn beside it.

    Parameters
    ----------
    results : Results
        Of the run.
    process : DrawingProcess
        That draws.
    """

    def __init__(self, results: Results, process: "DrawingProcess") -> None:
        from shapemorph.view import figures
        from shapemorph.view.shapes import (
            carried,
            deformed_figures,
            reference_figures,
            with_small_textures,
        )

        self._process = process
        load = results.load

        def images() -> list[GreyImage]:
            pair: FlattenedPair = load("flatten")
            return [side.calibrated.image for side in (pair.reference, pair.deformed)]

        # What the figures need of large results, and no more: it goes to another process.
        self._waiting: dict[str, _Job] = {
            "inputs": (
                process.draw_in_scene,
                reference_figures,
                lambda: (with_small_textures(load("reference")),),
            ),
            "flatten": (process.draw, figures.flattening_figures, lambda: (load("flatten"),)),
            "match": (
                process.draw,
                figures.matching_figures,
                lambda: (*images(), load("match")),
            ),
            "morph": (
                process.draw,
                figures.morph_figures,
                lambda: (images()[0], load("morph")),
            ),
            "correlate": (
                process.draw,
                figures.correlation_figures,
                lambda: (images()[0], load("correlate")),
            ),
            "align": (
                process.draw_in_scene,
                deformed_figures,
                lambda: (carried(with_small_textures(load("deformed")), load("align")),),
            ),
        }

    def reached(self, stage: str) -> None:
        """Ask for the figures of a stage, now that it is up to date."""
        if stage in self._waiting:
            ask, figures, nouns = self._waiting.pop(stage)
            ask(figures, *nouns())

    def all_reached(self, results: RunResults) -> None:
        """Ask for all other figures, now that every stage is up to date."""
        from shapemorph.view.figures import forming_figures, histogram_figures, law_figures
        from shapemorph.view.shapes import shape_figures, shapes_of

        for stage in tuple(self._waiting):
            self.reached(stage)
        self._process.draw_in_scene(shape_figures, shapes_of(results))
        self._process.draw(histogram_figures, results.measurement)
        if results.forming.figures:
            self._process.draw(forming_figures, results.measurement, results.forming)
        if results.spread and len(results.spread.laws) > 1:
            self._process.draw(law_figures, results, results.spread)

    def finish(self) -> "Pictures":
        """Wait for the figures."""
        return self._process.finish()
