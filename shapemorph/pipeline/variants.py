"""The same pair measured in other ways: what the stage `spread` repeats."""

from collections.abc import Callable
from dataclasses import dataclass

from shapemorph.config import (
    CorrelateConfig,
    FlattenConfig,
    LiftConfig,
    MatchConfig,
    MorphConfig,
    Section,
    SpreadConfig,
    StrainConfig,
)
from shapemorph.core.arrays import Floats
from shapemorph.core.errors import StageError
from shapemorph.core.flattened import FlattenedPair
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.landmarks import Landmarks
from shapemorph.core.laws import LawInputs, Variant
from shapemorph.core.matching import Matches
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.morphed import Morphed
from shapemorph.core.region import Region
from shapemorph.core.surface import StrainField, TrackedSurface


class SpreadSection(Section):
    """The sections of the stages that the spread repeats in other ways."""

    spread: SpreadConfig
    flatten: FlattenConfig
    match: MatchConfig
    morph: MorphConfig
    correlate: CorrelateConfig
    lift: LiftConfig
    strain: StrainConfig


@dataclass(frozen=True, slots=True)
class Runs:
    """The functions of the stages that are repeated."""

    flatten: Callable[..., FlattenedPair]
    match: Callable[..., Matches]
    morph: Callable[..., Morphed]
    correlate: Callable[..., CorrelationGrid]
    lift: Callable[..., TrackedSurface]
    strain: Callable[..., StrainField]


@dataclass(frozen=True, slots=True, eq=False)
class Whole:
    """What a whole measurement reads."""

    reference: TexturedMesh
    deformed: TexturedMesh
    region: Region | None
    meridian: Floats | None
    landmarks: Landmarks | None
    law_inputs: LawInputs


def measure_variants(
    whole: Whole,
    flat: tuple[FlattenedPair, Matches],
    main: tuple[CorrelationGrid, TrackedSurface],
    section: SpreadSection,
    runs: Runs,
) -> tuple[tuple[Variant, ...], dict[str, str]]:
    """Measure the pair again with each flattening and subset that is listed.

    Returns
    -------
    tuple of Variant, dict of str to str
        Differences from the main result, and the ways that led to nothing.
    """
    from shapemorph.stages.spread import FullResult, differ

    ways: dict[str, Section] = {
        **{
            f"flatten.method={method}": FlattenConfig(
                method=method, **section.flatten.model_dump(include=_OF_EVERY_FLATTENING)
            )
            for method in section.spread.flattenings
        },
        **{
            f"correlate.subset_size={size}": section.correlate.model_copy(
                update={"subset_size": size, "spacing": main[0].spacing}
            )
            for size in section.spread.subset_sizes
        },
    }
    if not ways:
        return (), {}
    known = FullResult(main[1], runs.strain(main[1], main[0], section.strain))
    found, lost = [], {}
    for name, way in ways.items():
        try:
            other = _in_another_way(whole, flat, section, way, runs)
        except StageError as error:
            lost[name] = str(error)
            continue
        found.append(differ(name, known, FullResult(*other)))
    return tuple(found), lost


_OF_EVERY_FLATTENING = {"px_per_mm", "speckle_px", "max_megapixels"}


def _in_another_way(
    whole: Whole,
    flat: tuple[FlattenedPair, Matches],
    section: SpreadSection,
    way: Section,
    runs: Runs,
) -> tuple[TrackedSurface, StrainField]:
    """Measure with another section `flatten` or `correlate`."""
    meshes = whole.reference, whole.deformed
    pair, matches = flat
    correlate = section.correlate
    if isinstance(way, FlattenConfig):
        pair = runs.flatten(*meshes, whole.meridian, way)
        matches = runs.match(*meshes, pair, whole.landmarks, whole.law_inputs, section.match)
    elif isinstance(way, CorrelateConfig):
        correlate = way
    morphed = runs.morph(*meshes, pair, matches, whole.law_inputs, section.morph)
    grid = runs.correlate(*meshes, whole.region, pair, morphed, correlate)
    tracked = runs.lift(*meshes, pair, grid, section.lift)
    return tracked, runs.strain(tracked, grid, section.strain)
