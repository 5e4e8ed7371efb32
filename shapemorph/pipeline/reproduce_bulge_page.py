"""The page of the reproduced bulge and its figures."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.status import PointStatus
from shapemorph.io.safe_files import whole_file

if TYPE_CHECKING:
    from shapemorph.core.flattened import FlattenedPair
    from shapemorph.core.morphed import Morphed
    from shapemorph.pipeline.reproduce_bulge import BulgeReproduction

OF_THE_RUN = ("shape_deformed", "morph_laws", "matches", "correlation")
"""Figures of the run with the main law that the paper has, too."""


def write_bulge_page(found: "BulgeReproduction", summary: dict[str, Any]) -> None:
    """Write index.html with figures/ beside it."""
    from shapemorph.view.reproduction_bulge import bulge_page_html

    figures = _draw(found, summary) if found.config.figures else []
    with whole_file(found.folder / "index.html") as partial:
        partial.write_text(bulge_page_html(summary, figures), encoding="utf-8")


def _draw(found: "BulgeReproduction", summary: dict[str, Any]) -> list[str]:
    from shapemorph.io.images import read_grey_image
    from shapemorph.methods.warping import warp_points
    from shapemorph.pipeline.flat_results import flat_results
    from shapemorph.view.calibrated_images import calibrated_figure
    from shapemorph.view.figures import encoded, write_pictures
    from shapemorph.view.first_guesses import agreement_figure, guess_figure
    from shapemorph.view.reproduction_bulge import (
        correspondence_figure,
        field_figure,
        frames_figure,
        noise_figure,
        radial_figure,
        stretch_figure,
    )

    main = next(iter(found.laws.values()))
    pair, morphed, grid = flat_results(main.folder)
    targets = warp_points(morphed.warp, grid.reference_px.reshape(-1, 2))
    guess = (grid, *targets, f"the law {next(iter(found.laws))}, and what correlation found")
    frames = [
        read_grey_image(found.folder / "twin" / state / f"frame_{number:03d}.png").grey
        for state in ("before", "after")
        for number in (0, len(found.twin.poses) // 3)
    ]
    points = {name: case.points for name, case in found.laws.items()}
    named = [
        ("10_photographs", frames_figure(frames)),
        ("11_calibrated", calibrated_figure(pair, morphed, grid)),
        ("13_points", correspondence_figure(*_both_shapes(found))),
        ("14_fields", field_figure(main.points)),
        ("15_profiles", radial_figure(points, _true_profile(found))),
        (
            "17_stretch",
            stretch_figure(points, {k: case.position for k, case in found.laws.items()}),
        ),
        ("18_first_guesses", guess_figure(*guess)),
        ("19_p_against_p0", agreement_figure(*guess)),
    ]
    if len(summary["over_noise"]) > 1:
        named.append(("16_noise", noise_figure(summary["over_noise"])))
    write_pictures(encoded(iter(named)), found.folder / "figures")
    _write_morph(found.folder, pair, morphed)
    own = [f"figures/{name}.png" for name, _ in named]
    run = main.folder.name
    others = [f"{run}/figures/{name}.png" for name in OF_THE_RUN]
    return own + [name for name in others if (found.folder / name).is_file()]


def _both_shapes(found: "BulgeReproduction") -> tuple[Floats, Floats, Floats]:
    """Positions before and after (N, 3) in the frame of the die, and material radii (N,)."""
    main = next(iter(found.laws.values()))
    points = main.points
    before = np.column_stack([points.material, np.zeros(len(points.material))])
    ok = main.measurement.arrays["status"] == PointStatus.OK
    after = main.measurement.arrays["deformed_position"][ok]
    radius = np.linalg.norm(points.material, axis=1)
    return before, found.twin.placed[1].inverse().apply(after), radius


def _true_profile(found: "BulgeReproduction") -> Floats:
    """Material radius, E1, E2 and height (K, 4) along a radius."""
    from shapemorph.methods.principal import principal
    from shapemorph.methods.synthetic.membrane.smooth import map_points

    reach = np.linspace(0.05, 0.95 * found.twin.edge, 300)
    place, slope = map_points(found.twin.maps[1], np.column_stack([reach, np.zeros_like(reach)]))
    strain = principal((np.swapaxes(slope, 1, 2) @ slope - np.eye(2)) / 2)[0]
    return np.column_stack([reach, strain, place[:, 2]])


def _write_morph(folder: Path, pair: "FlattenedPair", morphed: "Morphed") -> None:
    """Write the morph sequence from the flat to the flattened bulged shape, as an animation."""
    from shapemorph.config import MorphConfig
    from shapemorph.io.safe_files import remove_folder
    from shapemorph.methods.warp_inverse import inverse_warp
    from shapemorph.pipeline.sequence import make_sequence, write_sequence

    before, after = (side.calibrated.image for side in (pair.reference, pair.deformed))
    warps = morphed.warp, inverse_warp(morphed.warp, before.mask, after.shape)
    remove_folder(folder / "morph")
    (folder / "morph").mkdir()
    write_sequence(folder / "morph", make_sequence(before, after, warps, MorphConfig()))
