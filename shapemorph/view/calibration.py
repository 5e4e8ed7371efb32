"""Pictures of a calibration: where points were seen and how far off, view by view."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from shapemorph.core.calibration import Calibration
from shapemorph.methods.cameras.quality import residual_pattern
from shapemorph.view.figures import Named, encoded, write_pictures
from shapemorph.view.layout import EDGE, HEAD, Heading, write_heading
from shapemorph.view.style import (
    DEFORMED_COLOUR,
    FAINT,
    INK,
    REFERENCE_COLOUR,
    SMALL,
    new_figure,
    place_axes,
    round_length,
    write_text,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL, BETWEEN, BELOW = 620, 70, 90
"""Largest side of a picture, room between two and below, px."""
ARROW = 0.09
"""Length of the largest mean residual, of the width of a picture."""
BAR, MOST_BARS, BARS_TALL = 26, 60, 320
COLOURS = (REFERENCE_COLOUR, DEFORMED_COLOUR, "#009e73", "#cc79a7")


def write_calibration_figures(found: Calibration, folder: Path) -> None:
    """Draw ``residuals.png`` and ``views.png``; needs no OpenGL."""
    write_pictures(encoded(_figures(found)), folder)


def _figures(found: Calibration) -> Named:
    yield "residuals", residuals_figure(found)
    yield "views", views_figure(found)


def residuals_figure(found: Calibration) -> "Figure":
    """Show all points in the picture of each camera, and the mean residual of each cell."""
    count = len(found.rig.cameras)
    sizes = [np.array(camera.size) * PANEL / max(camera.size) for camera in found.rig.cameras]
    wide = EDGE * 2 + int(sum(size[0] for size in sizes)) + BETWEEN * count
    tall = HEAD + int(max(size[1] for size in sizes)) + BELOW + EDGE
    figure = new_figure(max(wide, 900), tall)
    note = f"reprojection rms {found.rms():.3g} px; arrows: mean of a cell, enlarged"
    write_heading(figure, Heading("Residuals of the calibration", note))
    left = float(EDGE + BETWEEN)
    for number in range(count):
        width, height = sizes[number]
        title = f"{found.rig.names[number]}: {found.rms(camera=number):.3g} px rms"
        write_text(figure, left, HEAD + 2, title, bold=True, size=SMALL)
        axes = place_axes(figure, left, HEAD + 30, width, height)
        _draw_pattern(axes, found, number)
        left += width + BETWEEN
    return figure


def _draw_pattern(axes: "Axes", found: Calibration, number: int) -> None:
    camera = found.rig.cameras[number]
    width, height = camera.size
    pattern = residual_pattern(found, number)
    seen = [one.pixels for one in found.sightings if one.camera == number]
    points = np.concatenate(seen)
    axes.plot(points[:, 0], points[:, 1], ".", color="#c9ced6", markersize=2.0, zorder=1)
    longest = float(np.linalg.norm(pattern.means, axis=1).max(initial=1e-6))
    stated = round_length(longest)
    scale = longest / (ARROW * width)
    x, y = pattern.centres.T
    dx, dy = pattern.means.T
    style: dict[str, Any] = {
        "angles": "xy",
        "scale_units": "xy",
        "scale": scale,
        "width": 0.004,
        "zorder": 2,
    }
    axes.quiver(x, y, dx, dy, color=COLOURS[number % len(COLOURS)], **style)
    at = 0.03 * width, 1.09 * height
    axes.quiver(*at, stated, 0, color=INK, clip_on=False, **style)
    axes.text(
        at[0] + 1.3 * stated / scale,
        at[1],
        f"{stated:g} px",
        fontsize=SMALL,
        color=INK,
        va="center",
    )
    axes.set_xlim(0, width)
    axes.set_ylim(height, 0)
    axes.tick_params(labelsize=SMALL * 0.7, colors=FAINT)


def views_figure(found: Calibration) -> "Figure":
    """Show the rms of each view for each camera as bars."""
    shown = min(len(found.views), MOST_BARS)
    count = len(found.rig.cameras)
    wide = max(BAR * shown * max(count, 2) // 2, 600)
    figure = new_figure(EDGE * 2 + BETWEEN + wide, HEAD + 30 + BARS_TALL + 150)
    note = f"first {shown} of {len(found.views)} views" if shown < len(found.views) else ""
    write_heading(figure, Heading("Reprojection rms of each view  [px]", note))
    axes = place_axes(figure, EDGE + BETWEEN, HEAD + 30, wide, BARS_TALL)
    place = np.arange(shown)
    for number, name in enumerate(found.rig.names):
        values = [found.rms(camera=number, view=view) for view in range(shown)]
        offset = (number - (count - 1) / 2) * 0.8 / count
        colour = COLOURS[number % len(COLOURS)]
        axes.bar(place + offset, values, 0.8 / count, color=colour, label=name)
    names = [view.name for view in found.views[:shown]]
    axes.set_xticks(place, names, rotation=60, ha="right")
    axes.tick_params(labelsize=SMALL * 0.75, colors=FAINT)
    axes.grid(axis="y", color="#e5e7eb", linewidth=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.legend(frameon=False, fontsize=SMALL * 0.8)
    return figure
