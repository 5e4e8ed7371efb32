"""All that a finished measurement consists of, for the figures and the report."""

import dataclasses
from dataclasses import dataclass
from typing import Any

from shapemorph.core.flattened import FlattenedPair
from shapemorph.core.forming import Forming
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.laws import LawSpread
from shapemorph.core.matching import Matches
from shapemorph.core.measurement import Measurement
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.morphed import Morphed
from shapemorph.core.surface import Alignment, StrainField, TrackedSurface


@dataclass(frozen=True, slots=True, eq=False)
class RunResults:
    """The result of every stage, and what was read.

    Attributes
    ----------
    pair : FlattenedPair
    matches : Matches
    morphed : Morphed
    grid : CorrelationGrid
    tracked : TrackedSurface
    alignment : Alignment
    field : StrainField
    measurement : Measurement
    summary : dict
        What `summary.json` holds: JSON-able, nested, one section per stage. The report
        gives a place of honour to ``verdict`` (``level`` PASS, WARN or FAIL and ``reasons``)
        and ``scorecard``, and prints every other section as a table.
    reference_mesh, deformed_mesh : TexturedMesh
    spread : LawSpread or None
        Of several morph laws; None: not asked for.
    forming : Forming
        Limits, sections, domes; empty where not asked for.
    """

    pair: FlattenedPair
    matches: Matches
    morphed: Morphed
    grid: CorrelationGrid
    tracked: TrackedSurface
    alignment: Alignment
    field: StrainField
    measurement: Measurement
    summary: dict[str, Any]
    reference_mesh: TexturedMesh
    deformed_mesh: TexturedMesh
    spread: LawSpread | None = None
    forming: Forming = dataclasses.field(default_factory=Forming)
