"""Which stages there are, in what order, and what each reads.

A stage is imported when it runs: looking at a finished run loads nothing heavy.
"""

from dataclasses import replace

from shapemorph.config import (
    AlignConfig,
    CorrelateConfig,
    FlattenConfig,
    LiftConfig,
    MatchConfig,
    MorphConfig,
    RunConfig,
    Section,
    StrainConfig,
)
from shapemorph.core.arrays import Bools, Floats
from shapemorph.core.errors import StageError
from shapemorph.core.flattened import FlattenedPair
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import CalibratedImage, GreyImage
from shapemorph.core.inputreports import InputReports
from shapemorph.core.landmarks import Landmarks
from shapemorph.core.laws import LawInputs, LawSpread, NodalField
from shapemorph.core.matching import Matches, Warp
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.morphed import Morphed
from shapemorph.core.region import Region
from shapemorph.core.surface import Alignment, StrainField, TrackedSurface
from shapemorph.pipeline.run import Stage
from shapemorph.pipeline.variants import Runs, SpreadSection, Whole, measure_variants


def _reports(reports: InputReports, section: None) -> InputReports:  # noqa: ARG001
    return reports


def _flatten(
    reference: TexturedMesh,
    deformed: TexturedMesh,
    meridian: Floats | None,
    section: FlattenConfig,
) -> FlattenedPair:
    from shapemorph.stages.flatten import flatten

    return flatten(reference, deformed, section, meridian)


def _match(
    reference: TexturedMesh,
    deformed: TexturedMesh,
    pair: FlattenedPair,
    landmarks: Landmarks | None,
    law_inputs: LawInputs,
    section: MatchConfig,
) -> Matches:
    from shapemorph.methods.charts.binding import match_by_page
    from shapemorph.methods.rough_start import dots_of_field, dots_of_landmarks
    from shapemorph.stages.match import match

    before = reference, pair.reference.calibrated
    after = deformed, pair.deformed.calibrated
    known = law_inputs.dots
    if known is None and landmarks is not None:
        known = dots_of_landmarks(landmarks, before, after)
    if known is None and isinstance(law_inputs.finite_elements, NodalField):
        known = dots_of_field(law_inputs.finite_elements, before, after)
    return match_by_page(
        lambda left, right, *dots: match(left, right, section, *dots),
        before[1],
        after[1],
        known,
        pair.pairs,
    )


def _morph(
    reference: TexturedMesh,
    deformed: TexturedMesh,
    pair: FlattenedPair,
    matches: Matches,
    law_inputs: LawInputs,
    section: MorphConfig,
) -> Morphed:
    from shapemorph.stages.morph import morph

    return morph(
        reference,
        pair.reference.calibrated,
        deformed,
        pair.deformed.calibrated,
        matches,
        law_inputs,
        section,
    )


def _correlate(
    reference: TexturedMesh,
    deformed: TexturedMesh,
    region: Region | None,
    pair: FlattenedPair,
    morphed: Morphed,
    section: CorrelateConfig,
) -> CorrelationGrid:
    from shapemorph.methods.even_spacing import even_spacing
    from shapemorph.methods.morphing import morph_surface
    from shapemorph.methods.subset_choice import choose_subset
    from shapemorph.stages.correlate import correlate

    image = pair.reference.calibrated

    def remorph(warp: Warp) -> GreyImage:
        return morph_surface(deformed, pair.deformed.calibrated, warp, image.image.shape)

    if section.spacing is None:
        choice = choose_subset(image.image, subset_size=section.subset_size, spacing=None)
        spacing = even_spacing(choice.spacing, pair.reference.distortion)
        section = section.model_copy(update={"spacing": spacing})
    limits = _region_pixels(region, reference, image)
    grain = _grain(reference, deformed, pair) if section.refinements else 0.0
    return correlate(image.image, remorph, morphed, section, limits, grain=grain)


def _grain(reference: TexturedMesh, deformed: TexturedMesh, pair: FlattenedPair) -> float:
    """Estimate what the noise of both meshes does to matches between their pictures."""
    from shapemorph.methods.mesh_noise import rough_vertex_noise
    from shapemorph.methods.threads import run_at_once
    from shapemorph.methods.vertex_averaging import pattern_grain

    noise = run_at_once(rough_vertex_noise, (reference, deformed))
    return pattern_grain(pair.reference.calibrated, pair.deformed.calibrated, noise)


def _lift(
    reference: TexturedMesh,
    deformed: TexturedMesh,
    pair: FlattenedPair,
    grid: CorrelationGrid,
    section: LiftConfig,
) -> TrackedSurface:
    from shapemorph.stages.lift import lift

    return lift(
        reference, pair.reference.calibrated, deformed, pair.deformed.calibrated, grid, section
    )


def _spread(  # noqa: PLR0913, PLR0917 - one for each name in `reads`
    reference: TexturedMesh,
    deformed: TexturedMesh,
    region: Region | None,
    meridian: Floats | None,
    landmarks: Landmarks | None,
    pair: FlattenedPair,
    matches: Matches,
    law_inputs: LawInputs,
    grid: CorrelationGrid,
    tracked: TrackedSurface,
    section: SpreadSection | None,
) -> LawSpread:
    from shapemorph.stages.morph import Side, law_warp
    from shapemorph.stages.spread import LawResult, spread

    if section is None:
        return spread((), {})
    sides = [
        Side(side.calibrated.image, mesh, side.calibrated)
        for mesh, side in ((reference, pair.reference), (deformed, pair.deformed))
    ]
    results: list[LawResult] = []
    failures: dict[str, str] = {}
    main = grid, tracked
    for law in section.morph.all_laws if section.morph.laws else ():
        config = section.morph.model_copy(update={"law": law})
        try:
            alone = law_warp(sides[0], sides[1], matches, law_inputs, config, law=law)
            if law != section.morph.law:
                morphed = _morph(reference, deformed, pair, matches, law_inputs, config)
                grid = _correlate(reference, deformed, region, pair, morphed, section.correlate)
                tracked = _lift(reference, deformed, pair, grid, section.lift)
        except StageError as error:
            failures[law] = str(error)
            continue
        results.append(LawResult(law, alone, grid, tracked))
    found = spread(results, failures)
    whole = Whole(reference, deformed, region, meridian, landmarks, law_inputs)
    runs = Runs(_flatten, _match, _morph, _correlate, _lift, _strain)
    variants, lost = measure_variants(whole, (pair, matches), main, section, runs)
    return replace(found, variants=variants, failures={**found.failures, **lost})


def _align(  # noqa: PLR0913, PLR0917 - one for each name in `reads`
    reference: TexturedMesh,
    deformed: TexturedMesh,
    landmarks: Landmarks | None,
    rigid_region: Region | None,
    pair: FlattenedPair,
    grid: CorrelationGrid,
    tracked: TrackedSurface,
    section: AlignConfig,
) -> Alignment:
    from shapemorph.stages.align import align

    rigid = _region_pixels(rigid_region, reference, pair.reference.calibrated)
    if rigid is not None:
        rigid = sample_at_grid(rigid, grid)
    return align(tracked, reference, deformed, landmarks, rigid, section)


def _strain(tracked: TrackedSurface, grid: CorrelationGrid, section: StrainConfig) -> StrainField:
    from shapemorph.stages.strain import strain

    return strain(tracked, grid, section)


STAGES: tuple[Stage, ...] = (
    Stage("inputs", _reports, ("reports",)),
    Stage(
        "flatten",
        _flatten,
        ("reference", "deformed", "meridian"),
        elsewhere=frozenset({"profile"}),
    ),
    Stage("match", _match, ("reference", "deformed", "flatten", "landmarks", "law_inputs")),
    Stage(
        "morph",
        _morph,
        ("reference", "deformed", "flatten", "match", "law_inputs"),
        elsewhere=frozenset({"laws", "images", "dots", "fe", "fe_deformed"}),
    ),
    Stage(
        "correlate",
        _correlate,
        ("reference", "deformed", "region", "flatten", "morph"),
        elsewhere=frozenset({"reference", "update_zncc", "update_strain"}),
    ),
    Stage("lift", _lift, ("reference", "deformed", "flatten", "correlate")),
    Stage(
        "spread",
        _spread,
        (
            "reference",
            "deformed",
            "region",
            "meridian",
            "landmarks",
            "flatten",
            "match",
            "all_law_inputs",
            "correlate",
            "lift",
        ),
    ),
    Stage(
        "align",
        _align,
        ("reference", "deformed", "landmarks", "rigid_region", "flatten", "correlate", "lift"),
        elsewhere=frozenset({"rigid_region"}),
    ),
    Stage("strain", _strain, ("lift", "correlate")),
)

SOURCES = (
    "reference",
    "deformed",
    "reports",
    "landmarks",
    "region",
    "rigid_region",
    "meridian",
    "law_inputs",
    "all_law_inputs",
)

COMPUTED = tuple(stage.name for stage in STAGES if stage.name != "inputs")


def sections(config: RunConfig) -> dict[str, Section | None]:
    """Section of every stage.

    The content of `inputs` comes in through its sources; `spread` repeats what others do,
    with their sections, and does nothing where no further laws or ways are listed.
    """
    repeated = SpreadSection(**{name: getattr(config, name) for name in SpreadSection.model_fields})
    asked = config.morph.laws or config.spread.flattenings or config.spread.subset_sizes
    special = {"inputs": None, "spread": repeated if asked else None}
    return {
        stage.name: special[stage.name] if stage.name in special else getattr(config, stage.name)
        for stage in STAGES
    }


def sample_at_grid(mask: Bools, grid: CorrelationGrid) -> Bools:
    """Look up a mask (H, W) at the points of a grid; whole px, False outside.

    Returns
    -------
    (R, C) bool
    """
    columns, rows = (grid.reference_px[..., axis].round().astype(int) for axis in (0, 1))
    height, width = mask.shape
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    sampled: Bools = inside & mask[rows.clip(0, height - 1), columns.clip(0, width - 1)]
    return sampled


def _region_pixels(
    region: Region | None, mesh: TexturedMesh, image: CalibratedImage
) -> Bools | None:
    if region is None:
        return None
    from shapemorph.methods.regions import region_mask

    return region_mask(region, mesh, image)
