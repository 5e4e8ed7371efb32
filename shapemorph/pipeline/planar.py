"""Two pictures of one material: their matches and morph sequence, or plain 2D correlation."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from shapemorph.config import RunConfig
from shapemorph.core.image import GreyImage
from shapemorph.core.laws import LawInputs
from shapemorph.core.matching import Matches, Warp
from shapemorph.io.safe_files import check_writable, move_files, scratch_folder, write_json
from shapemorph.pipeline.clock import Clock
from shapemorph.pipeline.picture_match import (
    follow_pictures,
    match_pictures,
    morph_by_law,
    picture_law_inputs,
)
from shapemorph.pipeline.pictures import read_picture_pair
from shapemorph.pipeline.planar_outputs import PlanarField, write_field, write_field_summary
from shapemorph.pipeline.run import Listener
from shapemorph.pipeline.run_facts import run_figures
from shapemorph.pipeline.sequence import MorphSequence, make_sequence, write_sequence
from shapemorph.pipeline.summary import matching_figures
from shapemorph.pipeline.unmatched import showing_failed_match


@dataclass(frozen=True, slots=True)
class PictureOutcome:
    """What was made of two pictures.

    Attributes
    ----------
    folder : Path
    files : tuple of Path
    summary : dict
        JSON-able.
    """

    folder: Path
    files: tuple[Path, ...]
    summary: dict[str, Any]


def morph_images(
    reference: Path, deformed: Path, folder: Path, config: RunConfig, *, listener: Listener
) -> PictureOutcome:
    """Match two pictures and write the matches, both warps and the morph sequence.

    Raises
    ------
    ConfigError, DataError, StageError
        Nothing is written then.
    """
    check_writable(folder)
    inputs = picture_law_inputs(config)
    clock = Clock(listener)
    pair = clock.run("read", lambda: read_picture_pair(reference, deformed, config, None))
    left, right = pair.reference, pair.deformed
    with showing_failed_match(folder, lambda: (left, right)):
        matches = clock.run("match", lambda: match_pictures(left, right, inputs, config))
    warps = clock.run("law", lambda: _both_warps(left, right, matches, inputs, config))
    sequence = clock.run("morph", lambda: make_sequence(left, right, warps, config.morph))
    with scratch_folder(folder) as scratch:
        clock.run("write", lambda: _write_morph(scratch, matches, warps, sequence))
        sections = {
            "inputs": pair.figures(),
            "match": matching_figures(matches),
            "morph": {"law": config.morph.law, **sequence.figures()},
            **run_figures(clock.seconds),
        }
        write_json(scratch / "summary.json", sections)
        files = move_files(scratch, folder, (reference, deformed))
        return PictureOutcome(folder, tuple(files), sections)


def correlate_images(
    reference: Path,
    deformed: Path,
    folder: Path,
    config: RunConfig,
    *,
    mask: Path | None,
    listener: Listener,
) -> PictureOutcome:
    """Correlate two pictures, however far apart they are, and write the displacement field.

    Parameters
    ----------
    mask : Path or None
        Picture of the size of the reference, white = measured.
    config : RunConfig
        Sections match, morph, correlate and strain, and `inputs.region`; `report.figures`
        says whether to draw.

    Raises
    ------
    ConfigError, DataError, StageError
        Nothing is written then.
    """
    from shapemorph.methods.first_calls import late_loops_compiled
    from shapemorph.methods.planar_strain import planar_strain

    check_writable(folder)
    inputs = picture_law_inputs(config)
    far = config.model_copy(update={"correlate": config.correlate.with_certainty()})
    clock = Clock(listener)
    with late_loops_compiled():
        pair = clock.run("read", lambda: read_picture_pair(reference, deformed, config, mask))
        left, right = pair.reference, pair.deformed
        with showing_failed_match(folder, lambda: (left, right)):
            found = follow_pictures(left, right, config, inputs, clock, far)
        grid = found.grid
        strain = clock.run("strain", lambda: planar_strain(grid, window=config.strain.window))
    field = PlanarField(left, grid, strain, found.matches, pair.figures())
    with scratch_folder(folder) as scratch:
        clock.run("write", lambda: write_field(scratch, field, config))
        sections = write_field_summary(scratch, field, config, clock.seconds)
        files = move_files(scratch, folder, [reference, deformed, *([mask] if mask else [])])
        return PictureOutcome(folder, tuple(files), sections)


def _both_warps(
    left: GreyImage, right: GreyImage, matches: Matches, inputs: LawInputs, config: RunConfig
) -> tuple[Warp, Warp]:
    """Forward and backward: those of the matches, or what the law has led to."""
    from shapemorph.methods.warp_inverse import inverse_warp

    if config.morph.law == "warp":
        return matches.forward, matches.backward
    forward = morph_by_law(left, right, matches, inputs, config).warp
    return forward, inverse_warp(forward, left.mask, right.shape)


def _write_morph(
    folder: Path, matches: Matches, warps: tuple[Warp, Warp], sequence: MorphSequence
) -> None:
    _write_matches(folder / "matches.csv", matches)
    _write_warp(folder / "warp_forward.npz", warps[0])
    _write_warp(folder / "warp_backward.npz", warps[1])
    write_sequence(folder, sequence)


def _write_matches(path: Path, matches: Matches) -> None:
    rows = np.column_stack([matches.reference_px, matches.deformed_px])
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(["x_ref_px", "y_ref_px", "x_def_px", "y_def_px"])
        writer.writerows(rows.tolist())


def _write_warp(path: Path, warp: Warp) -> None:
    np.savez(
        path, coefficients=warp.coefficients, origin=warp.origin, spacing=np.array(warp.spacing)
    )
