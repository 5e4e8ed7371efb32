"""Figures of a reproduced experiment: every method against the truth."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from shapemorph.core.arrays import Floats, Greys
from shapemorph.core.camera import Rig
from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus
from shapemorph.methods.twin_errors import TwinPoints
from shapemorph.view.layout import Heading
from shapemorph.view.panels import draw_photograph, draw_points, sheet
from shapemorph.view.plots import even_selection
from shapemorph.view.style import DEFORMED_COLOUR, INK, REFERENCE_COLOUR, SMALL

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ACROSS = 30
"""Points across a photograph that are drawn."""
STRIP = 0.01
"""Half width of the strip around a diameter that a profile shows, of the size."""
COLOURS = (REFERENCE_COLOUR, DEFORMED_COLOUR, "#2e7d4f", "#8a5fb0", "#b0772e")
WORDS = {
    "incremental": "incremental",
    "image_morphing": "image-morphing",
    "shape_morphing": "shape-morphing",
    "paper_incremental": "incremental, paper's settings",
    "paper_image_morphing": "image-morphing, paper's settings",
    "direct": "direct correlation",
}


def stereo_figure(pictures: Sequence[Greys], measured: Measurement, rig: Rig) -> "Figure":
    """Draw both pairs with the grid that was followed (left and right, first and last)."""
    ok = measured.arrays["status"] == PointStatus.OK
    some = even_selection(measured.arrays["reference_px"][ok], ACROSS)
    before = measured.reference[ok][some]
    after = before + measured.arrays["displacement"][ok][some]
    titles = ("left, first", "right, first", "left, last", "right, last")
    heading = Heading("Stereo pairs", "some of the points that were followed")
    figure, axes = sheet(titles, 2, heading)
    for k, (own, picture) in enumerate(zip(axes, pictures, strict=True)):
        seen = rig.cameras[k % 2].project(before if k < 2 else after)
        draw_photograph(own, picture)
        own.plot(seen[:, 0], seen[:, 1], ".", color=DEFORMED_COLOUR, markersize=1.6)
    return figure


def gradient_figure(measured: Measurement, rig: Rig) -> "Figure":
    """Map the displacement gradients between three pairs of pictures."""
    ok = measured.arrays["status"] == PointStatus.OK
    before = measured.reference[ok]
    after = before + measured.arrays["displacement"][ok]
    left, right = rig.cameras[:2]
    at = measured.arrays["reference_px"][ok]
    pairs = {
        "left, first to last": (left.project(before), left.project(after)),
        "first, left to right": (left.project(before), right.project(before)),
        "last, left to right": (left.project(after), right.project(after)),
    }
    names = ("u_x", "u_y", "v_x", "v_y")
    titles = [f"{name}; {pair}" for pair in pairs for name in names]
    heading = Heading("Displacement gradients", "over the first left picture, px per px")
    figure, axes = sheet(titles, 4, heading)
    for row, (source, target) in enumerate(pairs.values()):
        slopes = _slopes(at, source, target)
        for k, own in enumerate(axes[4 * row : 4 * row + 4]):
            draw_points(figure, own, at, slopes[:, k], "–")
            own.invert_yaxis()
    return figure


def field_figure(points: TwinPoints) -> "Figure":
    """Map displacement and strain as measured."""
    u, v, w = points.displacement.T
    fields = [
        ("u", u, "mm"),
        ("v", v, "mm"),
        ("w", w, "mm"),
        ("√(u² + v²)", np.hypot(u, v), "mm"),
        ("E₁, Green–Lagrange", points.strain[:, 0], "–"),
        ("E₂, Green–Lagrange", points.strain[:, 1], "–"),
    ]
    heading = Heading("Displacement and strain", "image-morphing, over the material")
    figure, axes = sheet([title for title, _, _ in fields], 3, heading)
    for own, (_, values, unit) in zip(axes, fields, strict=True):
        draw_points(figure, own, points.material, values, unit)
    return figure


def profile_figure(points: Mapping[str, TwinPoints], truth: Sequence[Floats]) -> "Figure":
    """Draw profiles over both diameters by every method, with the truth.

    Parameters
    ----------
    points : mapping of str to TwinPoints
    truth : three (N, 2) arrays
        Place and displacement: w and u along x, v along y.
    """
    wanted = (("w over x, y = 0", 2, 0), ("u over x, y = 0", 0, 0), ("v over y, x = 0", 1, 1))
    heading = Heading("Profiles", "lines: truth; points: measured in a strip around the diameter")
    figure, axes = sheet([f"{title}  [mm]" for title, _, _ in wanted], 3, heading)
    for own, line, (_, component, along) in zip(axes, truth, wanted, strict=True):
        for colour, (name, found) in zip(COLOURS, points.items(), strict=False):
            own.plot(
                *_strip(found, component, along),
                ".",
                color=colour,
                markersize=2.5,
                label=WORDS.get(name, name),
            )
        own.plot(line[:, 0], line[:, 1], "-", color=INK, linewidth=0.9, label="truth")
    axes[0].legend(fontsize=SMALL * 0.7, frameon=False)
    return figure


def error_figure(points: Mapping[str, TwinPoints]) -> "Figure":
    """Map the errors of u, v and w of every method against the truth."""
    titles = [f"{name}; {WORDS.get(method, method)}" for method in points for name in "uvw"]
    heading = Heading("Errors against the truth", "measured less true displacement, mm")
    figure, axes = sheet(titles, 3, heading)
    for row, found in enumerate(points.values()):
        for k in range(3):
            draw_points(figure, axes[3 * row + k], found.material, found.error[:, k], "mm")
    return figure


def likeness_figure(measured: Mapping[str, Measurement]) -> "Figure":
    """Map the ZNCC of the last match of every method, over the first picture of each."""
    heading = Heading("Likeness of the last match", "zero-mean normalised cross-correlation")
    figure, axes = sheet([WORDS.get(name, name) for name in measured], 3, heading)
    for own, found in zip(axes, measured.values(), strict=True):
        ok = found.arrays["status"] == PointStatus.OK
        draw_points(figure, own, found.arrays["reference_px"][ok], found.arrays["zncc"][ok], "–")
        own.invert_yaxis()
    return figure


def limits_figure(
    over_stretch: Sequence[Mapping[str, Any]], over_noise: Sequence[Mapping[str, Any]]
) -> "Figure":
    """Draw how errors grow with the largest stretch and with noise, method by method."""
    titles = (
        "error [mm rms] over the stretch",
        "share of points over the stretch",
        "error [mm rms] over noise [levels]",
    )
    figure, axes = sheet(titles, 3, Heading("Limits of each method", "against the truth"))
    methods = dict.fromkeys(str(row["method"]) for row in over_stretch)
    for colour, method in zip(COLOURS, methods, strict=False):
        rows = [row for row in over_stretch if row["method"] == method]
        place = [row["largest_stretch"] for row in rows]
        style: dict[str, Any] = {"color": colour, "label": WORDS.get(method, method)}
        axes[0].semilogy(place, [row["error_rms_mm"] for row in rows], "o-", markersize=4, **style)
        axes[1].plot(place, [row["share_of_points"] for row in rows], "o-", markersize=4, **style)
        noisy = [row for row in over_noise if row["method"] == method]
        levels = [row["noise_levels"] for row in noisy]
        axes[2].semilogy(
            levels, [row["error_rms_mm"] for row in noisy], "o-", markersize=4, **style
        )
    axes[1].legend(fontsize=SMALL * 0.7, frameon=False)
    return figure


def _slopes(at: Floats, source: Floats, target: Floats) -> Floats:
    """u_x, u_y, v_x, v_y (N, 4) of the shift from source to target, over the source."""
    from scipy.spatial import cKDTree

    _, near = cKDTree(at).query(at, k=9)
    away = source[near] - source[near].mean(axis=1, keepdims=True)
    shift = (target - source)[near]
    shift = shift - shift.mean(axis=1, keepdims=True)
    normal = np.swapaxes(away, 1, 2) @ away
    found: Floats = np.linalg.solve(normal, np.swapaxes(away, 1, 2) @ shift)
    return np.swapaxes(found, 1, 2).reshape(-1, 4)


def _strip(points: TwinPoints, component: int, along: int) -> tuple[Floats, Floats]:
    """Place along a diameter, and a component, of the points in a strip around it."""
    across = points.material[:, 1 - along]
    near = np.abs(across) < STRIP * np.ptp(points.material[:, along])
    return points.material[near, along], points.displacement[near, component]
