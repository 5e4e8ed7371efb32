"""Flat pictures: matches, the morph in detail, histograms."""

from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Greys, Ints
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Matches
from shapemorph.core.measurement import Measurement
from shapemorph.core.status import PointStatus
from shapemorph.view.layout import EDGE, HEAD, Heading, write_heading
from shapemorph.view.measures import MEASURES, measure_values
from shapemorph.view.style import (
    DEFORMED_COLOUR,
    FAINT,
    INK,
    REFERENCE_COLOUR,
    SMALL,
    new_figure,
    place_axes,
    reduced,
    write_text,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL, BETWEEN = 600, 60
"""Largest side of a picture and room between two, px."""
DOTS_ACROSS, LINES_ACROSS = 40, 6
"""Matches are shown, and joined by lines, in this many rows and columns of the reference."""
DETAIL, DETAIL_SIZE = 280, 420
"""Side of the detail of the morph, px of the picture and px of the figure."""


def matches_figure(matches: Matches, reference: GreyImage, deformed: GreyImage) -> "Figure":
    """Put both pictures side by side with the matched points, some of them joined by lines."""
    images = (reference, deformed)
    scales = [PANEL / max(image.shape) for image in images]
    (tall_0, wide_0), (tall_1, wide_1) = (
        [scale * length for length in image.shape]
        for scale, image in zip(scales, images, strict=True)
    )
    offset = wide_0 + BETWEEN
    across, tall = offset + wide_1, max(tall_0, tall_1)
    figure = new_figure(max(960, 2 * EDGE + across), HEAD + tall + EDGE)
    note = (
        f"{len(matches.reference_px)} pairs, median distance from the warp "
        f"{matches.residual_px:.2g} px; equal colours show the same material"
    )
    write_heading(figure, Heading("Matches: reference (left) and deformed (right)", note))
    axes = place_axes(figure, EDGE, HEAD, across, tall)
    axes.set_axis_off()
    _draw_pale(axes, reference, (0, wide_0, tall_0, 0))
    _draw_pale(axes, deformed, (offset, offset + wide_1, tall_1, 0))
    axes.set(xlim=(0, across), ylim=(tall, 0))
    start = (matches.reference_px + 0.5) * scales[0]
    end = (matches.deformed_px + 0.5) * scales[1] + [offset, 0]
    _draw_matches(axes, start, end)
    return figure


def _draw_pale(axes: "Axes", image: GreyImage, extent: tuple[float, float, float, float]) -> None:
    """Show a grey picture lightened, white outside its mask."""
    grey = np.where(image.mask, 0.55 + 0.45 * image.grey, 1.0).astype(np.float32)
    axes.imshow(reduced(grey, PANEL), cmap="gray", vmin=0, vmax=1, extent=extent, aspect="auto")


def _draw_matches(axes: "Axes", start: Floats, end: Floats) -> None:
    """Dots for all pairs and lines for an even selection of them, coloured by place."""
    from matplotlib.collections import LineCollection

    share = (start - start.min(axis=0)) / np.maximum(np.ptp(start, axis=0), 1e-9)
    tone = 0.7 * share[:, 0] + 0.3 * share[:, 1]
    for points in (start, end):
        axes.scatter(
            points[:, 0],
            points[:, 1],
            c=tone,
            cmap="plasma",
            s=16,
            linewidths=0.4,
            edgecolors="white",
        )
    chosen = even_selection(start, LINES_ACROSS)
    lines = LineCollection(
        np.stack([start[chosen], end[chosen]], axis=1).tolist(),
        array=tone[chosen],
        cmap="plasma",
        linewidths=1.1,
        alpha=0.9,
    )
    axes.add_collection(lines)


def even_selection(points: Floats, across: int) -> Ints:
    """Choose at most one point (N, 2) in each of across x across boxes; return their rows."""
    low, high = points.min(axis=0), points.max(axis=0)
    box = np.minimum(
        (across * (points - low) / np.maximum(high - low, 1e-9)).astype(np.int64), across - 1
    )
    _, first = np.unique(box @ [across, 1], return_index=True)
    return np.asarray(np.sort(first), dtype=np.int64)


def morph_figure(reference: GreyImage, morphed: GreyImage, good: Bools) -> "Figure":
    """Show a detail of the reference, of the morphed picture, and of one over the other.

    Parameters
    ----------
    good : (H, W) bool
        Where both pictures show something; the detail is taken near the middle of it.
    """
    rows, columns = _detail(good)
    pictures = [_stretched(image.grey[rows, columns]) for image in (reference, morphed)]
    overlay = np.stack([pictures[0], pictures[1], pictures[1]], axis=-1)
    titles = ("reference", "deformed, morphed", "both: red and cyan where they differ")
    figure = new_figure(4 * EDGE + 3 * DETAIL_SIZE, HEAD + DETAIL_SIZE + 60)
    size = f"{columns.stop - columns.start} x {rows.stop - rows.start} px"
    note = f"Detail of {size} in the middle of what both show, contrast stretched"
    write_heading(figure, Heading("Deformed picture laid over the reference", note))
    for k, (picture, title) in enumerate(zip((*pictures, overlay), titles, strict=True)):
        left = EDGE + k * (DETAIL_SIZE + EDGE)
        axes = place_axes(figure, left, HEAD, DETAIL_SIZE, DETAIL_SIZE)
        axes.imshow(picture, cmap="gray", vmin=0, vmax=1, interpolation="nearest")
        axes.set_axis_off()
        write_text(figure, left, HEAD + DETAIL_SIZE + 10, title, size=SMALL, colour=FAINT)
    return figure


def _detail(good: Bools) -> tuple[slice, slice]:
    """Rows and columns of a square around the good pixel nearest to the middle of all."""
    places = np.argwhere(good) if good.any() else np.argwhere(np.ones_like(good))
    middle = places[np.abs(places - places.mean(axis=0)).sum(axis=1).argmin()]
    side = min(DETAIL, *good.shape)
    start = np.clip(middle - side // 2, 0, np.array(good.shape) - side)
    return slice(int(start[0]), int(start[0]) + side), slice(int(start[1]), int(start[1]) + side)


def _stretched(grey: Greys) -> Greys:
    """Spread the middle 98 % of the grey levels over [0, 1]."""
    low, high = np.percentile(grey, [1, 99])
    return np.asarray(np.clip((grey - low) / max(high - low, 1e-6), 0, 1), dtype=np.float32)


def histograms_figure(measurement: Measurement) -> "Figure":
    """Distribution of strain, displacement and correlation over the points."""
    named = {measure.key: measure for measure in MEASURES}
    chosen = [named["E1"], named["E2"], named["displacement"]]
    values = [measure_values(measurement, measure) for measure in chosen]
    labels = [f"{m.name} {m.label}" for m in chosen]
    ok = measurement.arrays["status"] == PointStatus.OK
    values.append(np.where(ok, measurement.arrays["zncc"], np.nan))
    labels.append("Correlation ZNCC  [–]")
    figure = new_figure(1240, HEAD + 20 + 2 * 340)
    note = "Share of the points with a value; line: median, band: 1st to 99th percentile; log scale"
    write_heading(figure, Heading("Distributions", note))
    for k, (data, label) in enumerate(zip(values, labels, strict=True)):
        axes = place_axes(figure, EDGE + 70 + 610 * (k % 2), HEAD + 20 + 340 * (k // 2), 500, 240)
        _draw_histogram(axes, data[np.isfinite(data)], label)
    return figure


def _draw_histogram(axes: "Axes", values: Floats, label: str) -> None:
    """Bars in percent of the points, median and percentiles."""
    axes.set_xlabel(label, fontsize=SMALL, color=INK)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=SMALL * 0.85, colors=INK)
    if values.size == 0:
        return
    low, median, high = np.percentile(values, [1, 50, 99])
    axes.axvspan(low, high, color=REFERENCE_COLOUR, alpha=0.08, linewidth=0)
    counts, edges = np.histogram(values, bins=60)
    axes.stairs(100 * counts / values.size, edges, fill=True, color=REFERENCE_COLOUR)
    axes.axvline(median, color=DEFORMED_COLOUR, linewidth=2)
    axes.locator_params(axis="x", nbins=6)
    axes.set_yscale("log", subs=[])  # most of a specimen often hardly moves
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_ylim(bottom=0.8 * 100 / values.size)
    axes.set_ylabel("% of the points", fontsize=SMALL, color=INK)
    title = f"median {median:.4g},  1 % {low:.4g},  99 % {high:.4g}"
    axes.set_title(title, fontsize=SMALL, loc="left", y=1.0)
