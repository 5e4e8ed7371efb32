"""Two pictures of one material: their matches and morph sequence, or plain 2D correlation."""

import csv
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from shapemorph.config import RunConfig
from shapemorph.core.arrays import Bools
from shapemorph.core.errors import ConfigError, DataError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.laws import LawInputs
from shapemorph.core.matching import Matches, Warp
from shapemorph.core.morphed import Morphed
from shapemorph.io.images import read_grey_image, read_picture
from shapemorph.io.safe_files import check_writable, move_files, scratch_folder, write_json
from shapemorph.methods.colour_content import best_channel
from shapemorph.pipeline.law_inputs import read_law_inputs
from shapemorph.pipeline.planar_outputs import PlanarField, write_field, write_field_summary
from shapemorph.pipeline.run import Event, Listener
from shapemorph.pipeline.sequence import MorphSequence, make_sequence, write_sequence
from shapemorph.pipeline.summary import matching_figures, run_figures
from shapemorph.pipeline.unmatched import showing_failed_match

Result = TypeVar("Result")


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


class _Clock:
    """Times named steps and tells the listener."""

    def __init__(self, listener: Listener) -> None:
        self.seconds: dict[str, float] = {}
        self._listener = listener

    def run(self, name: str, work: Callable[[], Result]) -> Result:
        self._listener(Event(name, "started"))
        begin = time.perf_counter()
        result = work()
        self.seconds[name] = time.perf_counter() - begin
        self._listener(Event(name, "finished", self.seconds[name]))
        return result


def morph_images(
    reference: Path, deformed: Path, folder: Path, config: RunConfig, *, listener: Listener
) -> PictureOutcome:
    """Match two pictures and write the matches, both warps and the morph sequence.

    Raises
    ------
    ConfigError, DataError, StageError
        Nothing is written then.
    """
    from shapemorph.stages.match import match

    check_writable(folder)
    inputs = _law_inputs(config)
    clock = _Clock(listener)
    channel = config.inputs.channel
    pair = clock.run("read", lambda: _read_pair((reference, deformed), None, channel))
    left, right = pair.left, pair.right
    with showing_failed_match(folder, lambda: (left, right)):
        matches = clock.run("match", lambda: match(left, right, config.match))
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
        Sections match, morph, correlate and strain; `report.figures` says whether to draw.

    Raises
    ------
    ConfigError, DataError, StageError
        Nothing is written then.
    """
    from shapemorph.methods.planar_strain import planar_strain
    from shapemorph.stages.match import match

    check_writable(folder)
    inputs = _law_inputs(config)
    clock = _Clock(listener)
    channel = config.inputs.channel
    pair = clock.run("read", lambda: _read_pair((reference, deformed), mask, channel))
    left, right = pair.left, pair.right
    with showing_failed_match(folder, lambda: (left, right)):
        matches = clock.run("match", lambda: match(left, right, config.match))
    morphed = clock.run("morph", lambda: _morphed(left, right, matches, inputs, config))
    grid = clock.run("correlate", lambda: _correlate(left, right, morphed, config))
    strain = clock.run("strain", lambda: planar_strain(grid, window=config.strain.window))
    field = PlanarField(left, grid, strain, matches, pair.figures())
    with scratch_folder(folder) as scratch:
        clock.run("write", lambda: write_field(scratch, field, config))
        sections = write_field_summary(scratch, field, config, clock.seconds)
        files = move_files(scratch, folder, [reference, deformed, *([mask] if mask else [])])
        return PictureOutcome(folder, tuple(files), sections)


def _law_inputs(config: RunConfig) -> LawInputs:
    """Read what the law of two plain pictures needs."""
    morph = config.morph
    if morph.law == "fe" or (morph.law == "landmarks" and morph.dots is None):
        raise ConfigError(
            f"law {morph.law} needs two textured meshes, got two pictures: choose morph.law=warp, "
            "polynomial or identity, or landmarks with morph.dots"
        )
    return read_law_inputs(morph, (morph.law,), lambda _: 1.0, lambda: None)


def _both_warps(
    left: GreyImage, right: GreyImage, matches: Matches, inputs: LawInputs, config: RunConfig
) -> tuple[Warp, Warp]:
    """Forward and backward: those of the matches, or what the law has led to."""
    from shapemorph.methods.warp_inverse import inverse_warp

    if config.morph.law == "warp":
        return matches.forward, matches.backward
    forward = _morphed(left, right, matches, inputs, config).warp
    return forward, inverse_warp(forward, left.mask, right.shape)


def _morphed(
    left: GreyImage, right: GreyImage, matches: Matches, inputs: LawInputs, config: RunConfig
) -> Morphed:
    from shapemorph.stages.morph import morph_pictures

    return morph_pictures(left, right, matches, inputs, config.morph)


def _correlate(
    left: GreyImage, right: GreyImage, morphed: Morphed, config: RunConfig
) -> CorrelationGrid:
    from shapemorph.methods.morphing import morph_image
    from shapemorph.stages.correlate import correlate

    def remorph(warp: Warp) -> GreyImage:
        return morph_image(right, warp, left.shape)

    return correlate(left, remorph, morphed, config.correlate, None)


@dataclass(frozen=True, slots=True)
class _Pair:
    """Two pictures, and what of their colours became grey."""

    left: GreyImage
    right: GreyImage
    channel: str
    reason: str

    def figures(self) -> dict[str, Any]:
        """Section `inputs` of the summary."""
        return {"channel": self.channel, "channel_reason": self.reason}


def _read_pair(paths: tuple[Path, Path], mask: Path | None, channel: str) -> _Pair:
    reason = "as inputs.channel says"
    pictures = [read_picture(path, "luma" if channel == "auto" else channel) for path in paths]
    if channel == "auto":
        channel, reason = best_channel([picture.content for picture in pictures])
        if channel != "luma":
            pictures = [read_picture(path, channel) for path in paths]
    left, right = (GreyImage(picture.grey, picture.opaque) for picture in pictures)
    if mask is not None:
        left = GreyImage(left.grey, left.mask & _read_mask(mask, left.shape))
    return _Pair(left, right, channel, reason)


def _read_mask(path: Path, shape: tuple[int, int]) -> Bools:
    picture = read_grey_image(path)
    if picture.shape != shape:
        raise DataError(
            f"mask {path}: expected the size of the reference, {shape[1]} x {shape[0]} px, got "
            f"{picture.shape[1]} x {picture.shape[0]} px"
        )
    white: Bools = (picture.grey > 0.5) & picture.mask
    if not white.any():
        raise DataError(f"mask {path}: expected white where to measure, got none")
    return white


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
