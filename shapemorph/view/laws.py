"""Morph laws against what was measured: profiles of the shape, radii, and differences."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.laws import LawSpread
from shapemorph.core.results import RunResults
from shapemorph.core.status import PointStatus
from shapemorph.methods.laws.polynomial import fit_polynomial_law
from shapemorph.methods.warping import warp_points
from shapemorph.view.layout import EDGE, HEAD, Heading, write_heading
from shapemorph.view.style import FAINT, INK, SMALL, new_figure, place_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PROFILES = 16
"""Directions in which the shape is cut."""
ORDER = 5
"""Of the radial law that finds the centres."""
BINS = 60
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00")
"""One for each law, in the order in which they are listed."""
WIDE, TALL, BETWEEN = 430, 380, 96
"""Size of a panel and room between two, px."""


@dataclass(frozen=True, slots=True, eq=False)
class RadialView:
    """The measured points about an axis.

    Attributes
    ----------
    reference_px : (N, 2) float64
        Points with a value.
    radius, angle : (N,) float64
        Polar coordinates in the reference picture, mm and radians.
    deformed_radius : (N,) float64
        Distance from the centre of the deformed picture, mm.
    out, up : (N,) float64
        Distance from the axis and height along it after the deformation, mm.
    deformed_centre : (2,) float64
        px.
    px_per_mm : float
        Of the deformed picture.
    """

    reference_px: Floats
    radius: Floats
    angle: Floats
    deformed_radius: Floats
    out: Floats
    up: Floats
    deformed_centre: Floats
    px_per_mm: float


def laws_figure(results: RunResults, spread: LawSpread) -> "Figure":
    """Draw profiles of the deformed shape, and every law against what was measured."""
    view = radial_view(results)
    figure = new_figure(2 * EDGE + 60 + 3 * WIDE + 2 * BETWEEN, HEAD + TALL + 90)
    note = "; ".join(
        f"{law} {1e3 * rms:.2g} um rms"
        for law, rms in zip(spread.laws[1:], spread.rms[1:], strict=True)
    )
    note = f"Positions measured with each law, against those with {spread.laws[0]}: {note}"
    write_heading(figure, Heading("Morph laws against the measured one", note))
    panels = [
        place_axes(figure, EDGE + 60 + k * (WIDE + BETWEEN), HEAD, WIDE, TALL) for k in range(3)
    ]
    _draw_profiles(panels[0], view)
    _draw_radii(panels[1], view, spread)
    _draw_differences(panels[2], view, spread)
    for axes in panels:
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=SMALL * 0.85, colors=INK)
    return figure


def radial_view(results: RunResults) -> RadialView:
    """Place the measured points about the axis that they suggest."""
    ok = (results.grid.status == PointStatus.OK) & (results.tracked.status == PointStatus.OK)
    scales = [
        side.calibrated.chart.px_per_mm for side in (results.pair.reference, results.pair.deformed)
    ]
    reference_px, deformed_px = results.grid.reference_px[ok], results.grid.deformed_px[ok]
    pose = fit_polynomial_law(
        reference_px / scales[0], deformed_px / scales[1], order=ORDER, centre=None,
        coefficients=None,
    ).pose  # fmt: skip
    away = reference_px / scales[0] - pose.reference_centre
    radius = np.hypot(*away.T)
    out, height = _about_axis(results.tracked.deformed[ok], radius)
    height -= height[np.argmin(radius)]
    return RadialView(
        reference_px=reference_px,
        radius=radius,
        angle=np.arctan2(away[:, 1], away[:, 0]),
        deformed_radius=pose.radii(deformed_px / scales[1]),
        out=out,
        up=height * (1.0 if np.median(height) <= 0 else -1.0),
        deformed_centre=pose.deformed_centre * scales[1],
        px_per_mm=scales[1],
    )


def _about_axis(points: Floats, radius: Floats) -> tuple[Floats, Floats]:
    """Distance from the axis and height along it (N,) of points (N, 3) on rings.

    Points of one radius in the reference lie on a circle about the axis after the
    deformation, too, however the shape lies in its file. So the direction in which rings are
    thinnest is the axis, and one centre serves the circles of all rings.
    """
    ring = np.minimum((radius / radius.max() * BINS).astype(np.int64), BINS - 1)
    axes = np.linalg.svd(_off_mean(points, ring), full_matrices=False)[2]
    flat = (points - points.mean(axis=0)) @ axes.T
    plane = flat[:, :2]
    square = (plane**2).sum(axis=1, keepdims=True)
    centre, *_ = np.linalg.lstsq(2.0 * _off_mean(plane, ring), _off_mean(square, ring)[:, 0])
    return np.hypot(*(plane - centre).T), flat[:, 2]


def _off_mean(values: Floats, group: Ints) -> Floats:
    """Values (N, K) less the mean of their group."""
    size = np.maximum(np.bincount(group), 1)
    mean = np.stack([np.bincount(group, column) / size for column in values.T], axis=-1)
    less: Floats = values - mean[group]
    return less


def binned(place: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Median (BINS,) of values in equal bins of their place, and the middles of the bins."""
    edges = np.linspace(0.0, place.max(), BINS + 1)
    index = np.clip(np.digitize(place, edges) - 1, 0, BINS - 1)
    known = np.isfinite(values)
    medians = np.full(BINS, np.nan)
    for number in np.unique(index[known]):
        medians[number] = np.median(values[known & (index == number)])
    return (edges[1:] + edges[:-1]) / 2, medians


def _draw_profiles(axes: "Axes", view: RadialView) -> None:
    """Cut the shape along half-lines from the axis; over them the mean profile."""
    width = np.pi / PROFILES / 4
    for number in range(PROFILES):
        turned = view.angle - 2 * np.pi * number / PROFILES
        near = np.abs(np.angle(np.exp(1j * turned))) < width
        order = np.flatnonzero(near)[np.argsort(view.radius[near])]
        axes.plot(view.out[order], view.up[order], color=COLOURS[0], linewidth=0.8, alpha=0.8)
    out, up = (binned(view.radius, values)[1] for values in (view.out, view.up))
    axes.plot(
        out, up, color=COLOURS[4], linewidth=6, alpha=0.5, zorder=1,
        label="mean, along which a profile map unrolls",
    )  # fmt: skip
    axes.plot([], [], color=COLOURS[0], label=f"{PROFILES} measured profiles")
    axes.set_aspect("equal", adjustable="datalim")
    _name(axes, "distance from the axis [mm]", "height [mm]")


def _draw_radii(axes: "Axes", view: RadialView, spread: LawSpread) -> None:
    """Radius in the reference picture over radius in the deformed picture."""
    some = slice(None, None, max(1, len(view.radius) // 1500))
    axes.plot(
        view.deformed_radius[some], view.radius[some], ".", color=FAINT, markersize=2.5,
        label="measured points",
    )  # fmt: skip
    for law, colour, radius in _laws(view, spread):
        place, middle = binned(view.radius, radius)
        axes.plot(middle, place, color=colour, linewidth=1.8, label=law)
    _name(axes, "radius in the deformed picture [mm]", "radius in the reference picture [mm]")


def _draw_differences(axes: "Axes", view: RadialView, spread: LawSpread) -> None:
    """How far each law puts the radius off what was measured."""
    for law, colour, radius in _laws(view, spread):
        place, middle = binned(view.radius, radius - view.deformed_radius)
        axes.plot(place, middle, color=colour, linewidth=1.8, label=law)
    axes.axhline(0.0, color=FAINT, linewidth=0.8)
    _name(axes, "radius in the reference picture [mm]", "law - measured, deformed picture [mm]")


def _laws(view: RadialView, spread: LawSpread) -> list[tuple[str, str, Floats]]:
    """Name, colour and radius (N,) in the deformed picture of what each law says, mm."""
    found = []
    for number, (law, warp) in enumerate(zip(spread.laws, spread.warps, strict=True)):
        target, _gradient = warp_points(warp, view.reference_px)
        away = (target - view.deformed_centre) / view.px_per_mm
        found.append((law, COLOURS[number % len(COLOURS)], np.hypot(away[:, 0], away[:, 1])))
    return found


def _name(axes: "Axes", along: str, up: str) -> None:
    axes.set_xlabel(along, fontsize=SMALL, color=INK)
    axes.set_ylabel(up, fontsize=SMALL, color=INK)
    axes.legend(fontsize=SMALL * 0.85, frameon=False, loc="best")
