"""Forming-limit diagrams, and what was measured along sections."""

from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.forming import Cut, Forming
from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus
from shapemorph.view.layout import EDGE, HEAD, Heading, write_heading
from shapemorph.view.style import (
    DEFORMED_COLOUR,
    FAINT,
    INK,
    REFERENCE_COLOUR,
    SMALL,
    new_figure,
    place_axes,
    write_text,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
"""Of the lines of a panel, in order."""
DIAGRAM, ABOVE, SIDE = 620, 44, 350
"""Size of the diagram, room for words above and beside it, px."""
WIDE, TALL, BETWEEN = 520, 260, 100
"""Size of a panel of a section and room between two, px."""
_PATHS = (
    (-0.5, "uniaxial\nβ = −0.5"),
    (0.0, "plane strain\nβ = 0"),
    (1.0, "equibiaxial\nβ = 1"),
)


def limit_figure(measurement: Measurement, forming: Forming) -> "Figure":
    """Draw every point over minor and major Hencky strain, and the limit curve."""
    arrays = measurement.arrays
    ok = arrays["status"] == PointStatus.OK
    minor, major = arrays["hencky_2"][ok], arrays["hencky_1"][ok]
    figure = new_figure(2 * EDGE + 70 + DIAGRAM + SIDE, HEAD + ABOVE + DIAGRAM + 80)
    note = "Principal Hencky (true) strains ε₁ = ln λ₁ ≥ ε₂ = ln λ₂ in the tangent plane; β = ε₂/ε₁"
    write_heading(figure, Heading("Forming-limit diagram", note))
    axes = place_axes(figure, EDGE + 70, HEAD + ABOVE, DIAGRAM, DIAGRAM)
    _draw_paths(axes, minor, major, forming)
    axes.scatter(
        minor, major, s=5, color=REFERENCE_COLOUR, alpha=0.25, linewidths=0, rasterized=True
    )
    # One faint point would not be seen in the legend.
    axes.plot([], [], "o", markersize=4, color=REFERENCE_COLOUR, label="measured points")
    if forming.curve is not None:
        axes.plot(
            forming.curve.minor, forming.curve.major, color=DEFORMED_COLOUR, linewidth=2.5,
            label="limit curve",
        )  # fmt: skip
    if forming.critical is not None:
        place = arrays["hencky_2"][forming.critical], arrays["hencky_1"][forming.critical]
        axes.plot(
            *place, "o", markersize=11, markerfacecolor="none", markeredgecolor=INK,
            markeredgewidth=2, label="most critical point",
        )  # fmt: skip
    _name(axes, "minor strain ε₂  [–]", "major strain ε₁  [–]")
    for row, text in enumerate(_words(forming)):
        write_text(
            figure, EDGE + 70 + DIAGRAM + 30, HEAD + ABOVE + 26 * row, text, size=SMALL, colour=INK
        )
    return figure


def section_figure(measurement: Measurement, cut: Cut) -> "Figure":
    """Draw shape, displacement, strain and thinning along a section."""
    figure = new_figure(2 * EDGE + 80 + 2 * WIDE + BETWEEN, HEAD + 2 * TALL + BETWEEN + 70)
    point = ", ".join(f"{value:.4g}" for value in cut.plane.point)
    normal = ", ".join(f"{round(value, 4) + 0.0:g}" for value in cut.plane.normal)
    note = f"Plane through ({point}) mm with normal ({normal}), frame of the reference file"
    write_heading(figure, Heading(f"Section {cut.name}", note))
    panels = [
        place_axes(
            figure,
            EDGE + 80 + (k % 2) * (WIDE + BETWEEN),
            HEAD + (k // 2) * (TALL + BETWEEN - 20),
            WIDE,
            TALL,
        )
        for k in range(4)
    ]
    place = (cut.along_cut(measurement.reference) - cut.plane.point) @ cut.plane.along
    _draw_shapes(panels[0], measurement, cut, place)
    arrays = measurement.arrays
    displacement = cut.along_cut(arrays["displacement"])
    noise = cut.along_cut(arrays["sigma_uvw"])
    for k, name in enumerate("uvw"):
        _draw_line(panels[1], cut, place, (displacement[:, k], noise[:, k]), (name, COLOURS[k]))
    _name(panels[1], "along the section [mm]", "displacement [mm]")
    for k, name in enumerate(("E1", "E2")):
        values = cut.along_cut(arrays[name]), cut.along_cut(arrays[f"sigma_{name}"])
        _draw_line(panels[2], cut, place, values, (("E₁", "E₂")[k], COLOURS[k]))
    _name(panels[2], "along the section [mm]", "Green–Lagrange strain [–]")
    thinning = 100 * cut.along_cut(arrays["thinning"])
    spread = 100 * cut.along_cut((1 - arrays["thinning"]) * arrays["sigma_thickness_strain"])
    _draw_line(panels[3], cut, place, (thinning, spread), ("thinning", COLOURS[2]))
    _name(panels[3], "along the section [mm]", "thinning 1 − t/t₀ [%]")
    return figure


def _draw_shapes(axes: "Axes", measurement: Measurement, cut: Cut, place: Floats) -> None:
    """Draw reference and deformed shape, seen along the normal of the plane."""
    up = np.cross(cut.plane.normal, cut.plane.along)
    deformed = measurement.reference + measurement.arrays["displacement"]
    for points, name, colour in (
        (measurement.reference, "reference", REFERENCE_COLOUR),
        (deformed, "deformed", DEFORMED_COLOUR),
    ):
        seen = cut.along_cut(points) - cut.plane.point
        across = seen @ cut.plane.along if name == "deformed" else place
        _draw_line(axes, cut, across, (seen @ up, np.zeros(0)), (name, colour))
    axes.set_aspect("equal", adjustable="datalim")
    _name(axes, "along the section [mm]", "height [mm]")


def _draw_line(
    axes: "Axes",
    cut: Cut,
    place: Floats,
    values: tuple[Floats, Floats],
    look: tuple[str, str],
) -> None:
    """Draw values over the place, line by line of the cut, with a band of two sigma."""
    height, sigma = values
    name, colour = look
    for number, part in enumerate(np.split(np.arange(len(place)), np.flatnonzero(cut.starts)[1:])):
        axes.plot(
            place[part], height[part], color=colour, linewidth=1.6,
            label=name if number == 0 else None,
        )  # fmt: skip
        if len(sigma):
            low, high = height[part] - 2 * sigma[part], height[part] + 2 * sigma[part]
            axes.fill_between(place[part], low, high, color=colour, alpha=0.2, linewidth=0)


def _draw_paths(axes: "Axes", minor: Floats, major: Floats, forming: Forming) -> None:
    """Lines of constant ratio of the strains, out to where the points end."""
    finite = np.isfinite(minor) & np.isfinite(major)
    reach = 1.1 * float(np.percentile(major[finite], 99.9)) if finite.any() else 1.0
    if forming.curve is not None:
        reach = max(reach, 1.1 * float(forming.curve.major.max()))
    for ratio, name in _PATHS:
        axes.plot([0, ratio * reach], [0, reach], color=FAINT, linewidth=0.8, linestyle="--")
        axes.annotate(
            name, (ratio * reach, reach), fontsize=SMALL * 0.8, color=FAINT, ha="center",
            va="bottom", annotation_clip=False,
        )  # fmt: skip
    low = min(-0.55 * reach, 1.05 * float(minor[finite].min())) if finite.any() else -0.5
    axes.set(xlim=(low, 1.1 * reach), ylim=(min(0.0, float(np.nanmin(major, initial=0))), reach))


def _words(forming: Forming) -> list[str]:
    """List what stands beside the diagram."""
    figures = forming.figures["diagram"]
    point = figures["critical_point"]
    words = []
    if point is not None:
        words += [
            "Most critical point:",
            f"  ε₁ {point['hencky_1']:.3f}, ε₂ {point['hencky_2']:.3f}",
        ]
        words += [f"  thinning {100 * point['thinning']:.1f} %"]
    if forming.curve is None:
        return [*words, "No limit curve given"]
    if point is not None and "limit_margin" in point:
        margin, sigma = point["limit_margin"], point["sigma_limit_margin"]
        words += [f"  margin {margin:+.3f} ± {sigma:.3f}"]
    words += ["", f"Points above the curve: {figures['points_above_curve']}"]
    words += [f"Beyond its ends: {figures['points_beyond_ends_of_curve']}", ""]
    words += [f"Curve: {forming.curve.conditions.get('material', 'material unknown')}"]
    if figures["caveats"]:
        words += ["The curve may not hold here:"]
        words += [line for text in figures["caveats"] for line in _wrapped(text)]
    return words


def _wrapped(text: str) -> list[str]:
    import textwrap

    return textwrap.wrap(text, 38, initial_indent="– ", subsequent_indent="  ")


def _name(axes: "Axes", along: str, up: str) -> None:
    axes.set_xlabel(along, fontsize=SMALL, color=INK)
    axes.set_ylabel(up, fontsize=SMALL, color=INK)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=SMALL * 0.85, colors=INK)
    axes.legend(fontsize=SMALL * 0.85, frameon=False, loc="best")
