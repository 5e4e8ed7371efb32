"""The page of a reproduction and its figures."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.camera import Rig
from shapemorph.core.matching import Warp
from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus
from shapemorph.core.stereo_twin import StereoTwin
from shapemorph.io.measurement_files import read_vtp
from shapemorph.io.safe_files import whole_file
from shapemorph.methods.synthetic.membrane.smooth import map_points

SPARSE = 3.0  # times the distance of the measured points: knots of the warp over time
STIFFNESS = 1e-3  # of that warp

if TYPE_CHECKING:
    from shapemorph.pipeline.reproduce import Reproduction


def write_page(found: "Reproduction", summary: dict[str, Any], folder: Path) -> None:
    """Write index.html with figures/ beside it."""
    from shapemorph.view.reproduction_page import page_html

    figures = _draw(found, summary, folder) if found.config.figures else []
    with whole_file(folder / "index.html") as partial:
        partial.write_text(page_html(summary, figures), encoding="utf-8")


def _draw(found: "Reproduction", summary: dict[str, Any], folder: Path) -> list[str]:
    from shapemorph.io.images import read_grey_image
    from shapemorph.pipeline.flat_results import flat_results
    from shapemorph.view.calibrated_images import calibrated_figure
    from shapemorph.view.figures import encoded, write_pictures
    from shapemorph.view.reproduction import (
        error_figure,
        field_figure,
        gradient_figure,
        likeness_figure,
        limits_figure,
        profile_figure,
        stereo_figure,
    )

    last = len(found.twin.maps) - 1
    names = [f"{side}_{state:02d}.png" for state in (0, last) for side in ("left", "right")]
    pictures = [read_grey_image(found.twin_folder / name).grey for name in names]
    by_case = {
        name: read_vtp(case.folder / "measurement.vtp")[0] for name, case in found.cases.items()
    }
    measured = by_case["image_morphing"]
    points = {name: case.points for name, case in found.cases.items()}
    named = [
        ("01_stereo_pairs", stereo_figure(pictures, measured, found.twin.rig)),
        ("03_gradients", gradient_figure(measured, found.twin.rig)),
        ("05_fields", field_figure(points["image_morphing"])),
        ("06_calibrated", calibrated_figure(*flat_results(found.cases["shape_morphing"].folder))),
        ("07_profiles", profile_figure(points, _true_profiles(found.twin))),
        ("08_errors", error_figure(points)),
        ("10_zncc", likeness_figure(by_case)),
    ]
    if summary["over_stretch"]:
        limits = limits_figure(summary["over_stretch"], summary["over_noise"])
        named.append(("09_limits", limits))
    write_pictures(encoded(iter(named)), folder / "figures")
    _draw_stages(found, measured, folder)
    own = sorted(path.name for path in (folder / "figures").glob("*.png"))
    return [f"figures/{name}" for name in own] + _of_shapes(folder)


def _true_profiles(twin: StereoTwin) -> tuple[Floats, Floats, Floats]:
    """Place and true displacement along diameters: w and u along x, v along y."""
    place = np.linspace(-0.97, 0.97, 400) * twin.radius
    along_x = np.column_stack([place, np.zeros_like(place)])
    profiles = []
    for material, component in ((along_x, 2), (along_x, 0), (along_x[:, ::-1].copy(), 1)):
        first, last = (map_points(twin.maps[state], material)[0] for state in (0, -1))
        profiles.append(np.column_stack([place, (last - first)[:, component]]))
    return profiles[0], profiles[1], profiles[2]


def _draw_stages(found: "Reproduction", measured: Measurement, folder: Path) -> None:
    """Draw how image-morphing bridges the views of the last state, as pictures and animation.

    The left one is limited to where the measured part of the first one has gone.
    """
    from shapemorph.methods.carried_mask import limit_to_carried
    from shapemorph.methods.warping import warp_points
    from shapemorph.pipeline.clock import Clock
    from shapemorph.pipeline.image_morphing import bridge_pictures
    from shapemorph.pipeline.pictures import with_sizes
    from shapemorph.pipeline.reproduce_limits import settings_of, silent
    from shapemorph.pipeline.sequence import make_sequence, write_sequence
    from shapemorph.pipeline.stereo_inputs import stereo_sequence
    from shapemorph.view.figures import encoded, write_pictures
    from shapemorph.view.first_guesses import agreement_figure, guess_figure
    from shapemorph.view.stages import stages_figure

    run = settings_of(found.config, found.twin_folder, "image_morphing", paper=False)
    sequence = stereo_sequence(run)
    left, right = (sequence.picture(side, sequence.states - 1) for side in ("left", "right"))
    first = sequence.first()
    left = limit_to_carried(left, first, _over_time(measured, found.twin.rig, first.shape))
    bridged = bridge_pictures(left, right, with_sizes(run, left), Clock(silent), views=True)
    way = make_sequence(left, right, bridged.warps, run.morph)
    at = bridged.grid.reference_px.reshape(-1, 2)
    near, far = bridged.carried.swapaxes(0, 1)
    grids = (near, bridged.middle.early, bridged.middle.late, far)
    guess = (bridged.grid, *warp_points(bridged.start, at), "last state, left to right")
    named = [
        ("02_stages", stages_figure(way.pictures, bridged.matches, bridged.warps, grids)),
        ("11_first_guesses", guess_figure(*guess)),
        ("12_p_against_p0", agreement_figure(*guess)),
    ]
    write_pictures(encoded(iter(named)), folder / "figures")
    (folder / "morph").mkdir(exist_ok=True)
    if not (folder / "morph" / "sequence").exists():
        write_sequence(folder / "morph", way)


def _over_time(measured: Measurement, rig: Rig, shape: tuple[int, int]) -> Warp:
    """Warp from the first left picture to the last, through what was measured."""
    from shapemorph.methods.warp_fit import fit_warp

    ok = measured.arrays["status"] == PointStatus.OK
    before = measured.reference[ok]
    source, target = (
        rig.cameras[0].project(at) for at in (before, before + measured.arrays["displacement"][ok])
    )
    spacing = SPARSE * float(np.sqrt(np.ptp(source, axis=0).prod() / len(source)))
    high = np.array(shape[::-1]) - 1.0
    extent = (-np.full(2, spacing), high + spacing)
    return fit_warp(source, target, extent=extent, spacing=spacing, smoothing=STIFFNESS)


def _of_shapes(folder: Path) -> list[str]:
    """Figures of the run by shape-morphing that the paper has, too."""
    run = folder / "shape_morphing" / "figures"
    chosen = ("shape_reference", "shape_deformed", "morph", "matches")
    found = (path for path in sorted(run.glob("*.png")) if path.stem in chosen)
    return [f"shape_morphing/figures/{path.name}" for path in found]
