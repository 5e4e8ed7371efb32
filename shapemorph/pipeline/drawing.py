"""Which figures show which stages, and asking for each as soon as it can be drawn."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from shapemorph.core.results import RunResults
from shapemorph.pipeline.run import Results

if TYPE_CHECKING:
    from shapemorph.view.drawing_process import DrawingProcess, Pictures
    from shapemorph.view.figures import Named


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

        self._results = results
        self._process = process
        self._waiting: dict[str, Callable[..., Named]] = {
            "flatten": figures.flattening_figures,
            "match": figures.matching_figures,
            "morph": figures.morph_figures,
            "correlate": figures.correlation_figures,
        }

    def reached(self, stage: str) -> None:
        """Ask for the figures of a stage, now that it is up to date."""
        if figures := self._waiting.pop(stage, None):
            shown = dict.fromkeys(("flatten", stage))
            self._process.draw(figures, *(self._results.load(name) for name in shown))

    def all_reached(self, results: RunResults) -> None:
        """Ask for all other figures, now that every stage is up to date."""
        from shapemorph.view.figures import histogram_figures, law_figures
        from shapemorph.view.shapes import shapes_of

        for stage in tuple(self._waiting):
            self.reached(stage)
        self._process.draw_shapes(shapes_of(results))
        self._process.draw(histogram_figures, results.measurement)
        if results.spread and len(results.spread.laws) > 1:
            self._process.draw(law_figures, results, results.spread)

    def finish(self) -> "Pictures":
        """Wait for the figures."""
        return self._process.finish()
