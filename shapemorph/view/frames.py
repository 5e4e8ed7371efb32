"""The overview of a sequence of pictures: how the field grows from one to the next."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from shapemorph.view.figures import encoded, write_pictures
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

Row = Mapping[str, Any]

WIDE, TALL, ROOM, BELOW = 560, 260, 90, 96
"""Size of a plot, room beside it for numbers, below it for names, px."""
MOST_NAMES = 12
PLOTS: tuple[tuple[str, tuple[tuple[str, str, str], ...]], ...] = (
    (
        "Displacement, median  [px]",
        (("u_median_px", "u", REFERENCE_COLOUR), ("v_median_px", "v", DEFORMED_COLOUR)),
    ),
    (
        "Green–Lagrange strain  [–]",
        (
            ("E1_median", "E₁, median", REFERENCE_COLOUR),
            ("E1_p99", "E₁, 99 % of the points below", DEFORMED_COLOUR),
            ("E2_median", "E₂, median", INK),
        ),
    ),
    ("Correlation, median ZNCC  [–]", (("zncc_median", "", INK),)),
    ("Share of points with a value  [–]", (("ok_share", "", INK),)),
)
"""Title of each plot, and of its lines column, name and colour."""


def write_frames_figure(rows: Sequence[Row], folder: Path, theme: str = "light") -> None:
    """Draw ``frames.png`` from the rows of frames.csv."""
    write_pictures(encoded(iter([("frames", frames_figure(rows))]), theme), folder)


def frames_figure(rows: Sequence[Row]) -> "Figure":
    """Plot displacement, strain, correlation and points over the pictures."""
    across, down = WIDE + ROOM, TALL + BELOW
    figure = new_figure(EDGE + 2 * across, HEAD + 2 * down + EDGE)
    count = len(rows)
    note = f"{count} picture{'s' if count > 1 else ''} after the first, to which all refer"
    write_heading(figure, Heading("The sequence", note))
    for k, (title, lines) in enumerate(PLOTS):
        left = EDGE + ROOM - 24 + across * (k % 2)
        top = HEAD + 30 + down * (k // 2)
        write_text(figure, left, top - 28, title, bold=True, size=SMALL)
        axes = place_axes(figure, left, top, WIDE, TALL)
        _draw_lines(axes, rows, lines)
        _name_frames(axes, [str(row["frame"]) for row in rows])
    return figure


def _draw_lines(axes: "Axes", rows: Sequence[Row], lines: Sequence[tuple[str, str, str]]) -> None:
    place = np.arange(1, len(rows) + 1)
    for column, name, colour in lines:
        values = [float(row[column]) for row in rows]
        axes.plot(place, values, color=colour, label=name, linewidth=1.8, marker="o", markersize=4)
    if lines[0][0] == "ok_share":
        axes.set_ylim(0, 1.05)
    axes.grid(axis="y", color="#e5e7eb", linewidth=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.tick_params(labelsize=SMALL * 0.8, colors=FAINT)
    axes.ticklabel_format(axis="y", useOffset=False)
    if len(lines) > 1:
        axes.legend(frameon=False, fontsize=SMALL * 0.8)


def _name_frames(axes: "Axes", names: Sequence[str]) -> None:
    """Put names below the axis, of as many pictures as there is room for."""
    step = max(1, -(-len(names) // MOST_NAMES))
    shown = range(0, len(names), step)
    labels = [_short(names[k]) for k in shown]
    axes.set_xticks([k + 1 for k in shown], labels, rotation=30, ha="right")
    axes.set_xlim(0.5, len(names) + 0.5)


def _short(name: str) -> str:
    return name if len(name) <= 14 else f"…{name[-13:]}"
