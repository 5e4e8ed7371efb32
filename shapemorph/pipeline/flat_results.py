"""What a run of shape-morphing has found in its flattened pictures."""

from pathlib import Path

from shapemorph.core.flattened import FlattenedPair
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.morphed import Morphed


def flat_results(run: Path) -> tuple[FlattenedPair, Morphed, CorrelationGrid]:
    """Read the flattened shapes, the morphed picture and the grid of a finished run."""
    from shapemorph.io.store import RunStore

    store = RunStore(run)
    return store.load("flatten"), store.load("morph"), store.load("correlate")
