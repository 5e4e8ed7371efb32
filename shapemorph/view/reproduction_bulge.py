"""Figures and page of the reproduced bulge: every law against the truth."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from shapemorph.core.arrays import Floats, Greys
from shapemorph.methods.twin_errors import TwinPoints
from shapemorph.view.layout import Heading
from shapemorph.view.pages import mean_and_spread, plain_page
from shapemorph.view.panels import draw_photograph, draw_points, sheet
from shapemorph.view.style import DEFORMED_COLOUR, INK, REFERENCE_COLOUR, SMALL

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TILT = np.deg2rad(35.0)
"""Between the axis and the line of sight of the drawn shapes, from the side."""
COLOURS = (DEFORMED_COLOUR, REFERENCE_COLOUR, "#2e7d4f", "#8a5fb0")
BIN, LEAST = 0.1, 20
"""Width of a bin of stretch, and points that it must hold to be drawn."""
FAINT_STRAIN = 0.02
"""E2 from which the degree of anisotropy is drawn."""


def frames_figure(pictures: Sequence[Greys]) -> "Figure":
    """Draw photographs of both states (two before, two after)."""
    titles = ("before", "before, turned by a third", "after", "after, turned by a third")
    note = "the cone of dots turns with the part; the lights, and with them the glare, do not"
    figure, axes = sheet(titles, 2, Heading("Photographs", note))
    for own, picture in zip(axes, pictures, strict=True):
        draw_photograph(own, picture)
    return figure


def correspondence_figure(before: Floats, after: Floats, radius: Floats) -> "Figure":
    """Draw the same points on both shapes, from the side, coloured by their radius before.

    Parameters
    ----------
    before, after : (N, 3)
        In the frame of the die, mm.
    radius : (N,)
        mm.
    """
    heading = Heading("Corresponding points", "seen from the side; colour: radius before  [mm]")
    figure, axes = sheet(("before", "after"), 2, heading)
    low, high = before.min(axis=0), before.max(axis=0)
    for own, points in zip(axes, (before, after), strict=True):
        up = points[:, 2] * np.cos(TILT) + points[:, 1] * np.sin(TILT)
        towards = points[:, 2] * np.sin(TILT) - points[:, 1] * np.cos(TILT)
        order = np.argsort(towards, kind="stable")  # near ones last
        shown = np.column_stack([points[:, 0], up])[order]
        draw_points(figure, own, shown, radius[order], "mm")
        own.set_xlim(1.1 * low[0], 1.1 * high[0])
    return figure


def field_figure(points: TwinPoints) -> "Figure":
    """Map what was measured, and below each strain its error against the truth."""
    u, v, w = points.displacement.T
    e1, e2 = points.strain.T
    off = points.strain - points.true_strain
    anisotropy, true_anisotropy = (
        strain[:, 0] / np.where(strain[:, 1] > FAINT_STRAIN, strain[:, 1], np.nan)
        for strain in (points.strain, points.true_strain)
    )
    fields = [
        ("u", u, "mm"), ("v", v, "mm"), ("w", w, "mm"),
        ("E₁, Green–Lagrange", e1, "–"), ("E₂, Green–Lagrange", e2, "–"),
        ("anisotropy E₁/E₂", anisotropy, "–"),
        ("error of E₁", off[:, 0], "–"), ("error of E₂", off[:, 1], "–"),
        ("error of E₁/E₂", anisotropy - true_anisotropy, "–"),
    ]  # fmt: skip
    heading = Heading("Displacement and strain", "over the material; errors against the truth")
    figure, axes = sheet([title for title, _, _ in fields], 3, heading)
    for own, (_, values, unit) in zip(axes, fields, strict=True):
        known = np.isfinite(values)
        draw_points(figure, own, points.material[known], values[known], unit)
    return figure


def radial_figure(points: Mapping[str, TwinPoints], truth: Floats) -> "Figure":
    """Draw strain over the material radius by every law, with the truth.

    Parameters
    ----------
    points : mapping of str to TwinPoints
    truth : (K, 4)
        Radius, E1, E2 and height.
    """
    titles = ("E₁ over the radius  [mm]", "E₂ over the radius  [mm]", "w over the radius  [mm]")
    heading = Heading("Along the radius", "lines: truth; points: measured, all around")
    figure, axes = sheet(titles, 3, heading)
    for colour, (name, found) in zip(COLOURS, points.items(), strict=False):
        radius = np.linalg.norm(found.material, axis=1)
        for own, values in zip(axes, (*found.strain.T, found.displacement[:, 2]), strict=True):
            own.plot(radius, values, ".", color=colour, markersize=1.2, label=name)
    for own, values in zip(axes, truth[:, 1:].T, strict=True):
        own.plot(truth[:, 0], values, "-", color=INK, linewidth=1.0, label="truth")
        own.set_ylim(min(0.0, values.min()) - 0.1, 1.12 * values.max())
    axes[0].legend(fontsize=SMALL * 0.7, frameon=False, markerscale=6)
    return figure


def stretch_figure(points: Mapping[str, TwinPoints], position: Mapping[str, Floats]) -> "Figure":
    """Draw how errors grow with the largest true stretch of a point, law by law.

    Parameters
    ----------
    points : mapping of str to TwinPoints
    position : mapping of str to (N, 3) array
        Error of the position after, mm.
    """
    titles = ("position  [mm rms]", "E₁  [rms]", "E₂  [rms]")
    note = f"root mean square of the points about a true stretch λ₁; {LEAST} or more of them"
    figure, axes = sheet(titles, 3, Heading("Errors over the stretch", note))
    for colour, (name, found) in zip(COLOURS, points.items(), strict=False):
        stretch = np.sqrt(1 + 2 * found.true_strain[:, 0])
        strain = found.strain - found.true_strain
        errors = (np.linalg.norm(position[name], axis=1), *np.abs(strain).T)
        for own, values in zip(axes, errors, strict=True):
            own.plot(*_binned_rms(stretch, values), "o-", color=colour, markersize=4, label=name)
    for own in axes:
        own.set_yscale("log")
        own.set_xlabel("λ₁", fontsize=SMALL)
    axes[0].legend(fontsize=SMALL * 0.7, frameon=False)
    return figure


def _binned_rms(place: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Middles of the bins that hold enough, and the root mean square of the values in them."""
    known = np.isfinite(values)
    number = np.floor(place[known] / BIN).astype(np.int64)
    count = np.bincount(number)
    enough = count >= LEAST
    squares = np.bincount(number, values[known] ** 2)
    middles = np.asarray((np.flatnonzero(enough) + 0.5) * BIN, dtype=np.float64)
    return middles, np.sqrt(squares[enough] / count[enough])


def noise_figure(over_noise: Sequence[Mapping[str, Any]]) -> "Figure":
    """Draw how errors and lost points grow with the noise of the photographs."""
    titles = ("error of position [mm rms] over noise [levels]", "share of points over noise")
    figure, axes = sheet(titles, 2, Heading("Noise", "everything after the calibration repeated"))
    place = [row["noise_levels"] for row in over_noise]
    for own, key in zip(axes, ("error_rms_mm", "share_of_points"), strict=True):
        values = np.array([row[key] for row in over_noise], dtype=np.float64)
        own.plot(place, values, "o-", color=COLOURS[0], markersize=4)
        own.set_ylim(0, 1.15 * np.max(values, initial=1e-6, where=np.isfinite(values)))
    return figure


def bulge_page_html(summary: Mapping[str, Any], figures: Sequence[str]) -> str:
    """Write the page as HTML; figures lie beside it."""
    return plain_page(
        "reproduction_bulge.html.j2",
        rows=[_row(name, law) for name, law in summary["laws"].items()],
        agree=summary["laws_agree_mm"],
        glare=summary["glare"],
        shapes=summary["shapes"],
        figures=figures,
    )


def _row(name: str, law: Mapping[str, Any]) -> dict[str, Any]:
    truth, rms = law["against_truth"], law["rms_away_from_kink"]
    keys = ("u", "v", "w", "E1", "E2")
    return {
        "name": name,
        "report": f"law_{name}/report.html",
        "points": law["points"],
        "far_points": law["points_away_from_kink"],
        "truth": [mean_and_spread(truth[key]) for key in keys],
        "rms": [f"{rms[key]:.4f}" for key in ("position_mm", "displacement_mm", "E1", "E2")],
        "largest": f"{law['largest_E1']:.2f}",
        "seconds": f"{law['seconds']:.0f}",
    }
