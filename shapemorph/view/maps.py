"""Maps in px over a flattened picture: correlation, status, distortion."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.arrays import Codes, Floats
from shapemorph.core.flattened import FlattenedPair, FlattenedSurface
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.status import PointStatus, count_statuses
from shapemorph.view.colour_bar import draw_colour_bar
from shapemorph.view.layout import BAR, EDGE, HEAD, Heading, write_heading
from shapemorph.view.rulers import Box, Ruler, Side
from shapemorph.view.style import (
    FAINT,
    SMALL,
    STATUS_COLOURS,
    STATUS_WORDS,
    ColourScale,
    colour_scale,
    new_figure,
    place_axes,
    place_patch,
    reduced,
    write_text,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL, PANEL_ROOM, PANEL_HEAD = 560, 150, 76
"""Largest side of a map, room beside it for its colour bar, above it for its title, px."""
NARROW = 0.6
"""Maps of less than this share of their height stand all in one row."""
LONG = 2.0
"""Width over height of pictures that are shown below each other."""
LEAST_DISTORTION = 0.1
"""Colours of a distortion reach at least that far from none: less is not worth a look."""
AXIS_ROOM, STEPS = 46, 5
"""Room for the numbers at the axes, px; steps between them, at most."""


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """A map with its colours.

    Attributes
    ----------
    title : str
    values : (R, C) float64
        NaN is left out.
    extent : (4,) tuple of float
        Left, right, bottom, top of the map in px of the picture, outer edges of its pixels.
    label : str
        Of the colour bar.
    scale : ColourScale or None
        None: fitted to the values.
    """

    title: str
    values: Floats
    extent: tuple[float, float, float, float]
    label: str
    scale: ColourScale | None = None


def _panel_grid(
    count: int, shapes: Sequence[tuple[int, int]], heading: Heading
) -> "tuple[Figure, list[Box]]":
    """Make the figure for maps, two in a row, all where they are narrow, one where long.

    A long one, such as charts side by side, gets twice the width. Returns the figure and
    the boxes of the maps (left, top, width, height).
    """
    long = all(width > LONG * height for height, width in shapes)
    side = 2 * PANEL if long else PANEL
    sizes = [np.array(shape[::-1]) * side / max(shape) for shape in shapes]
    narrow = max(size[0] for size in sizes) < NARROW * side
    columns = 1 if long else count if narrow else min(2, count)
    room = AXIS_ROOM + PANEL_ROOM
    wide = [max(size[0] for size in sizes[k::columns]) + room for k in range(columns)]
    tall = [max(size[1] for size in sizes[k : k + columns]) for k in range(0, count, columns)]
    height = HEAD + sum(tall) + PANEL_HEAD * len(tall) + EDGE
    figure = new_figure(max(heading.width, EDGE + sum(wide)), height)
    write_heading(figure, heading)
    boxes = []
    for k, size in enumerate(sizes):
        row, column = divmod(k, columns)
        left = EDGE + AXIS_ROOM + sum(wide[:column])
        top = HEAD + sum(tall[:row]) + PANEL_HEAD * row + 34
        boxes.append((float(left), float(top), float(size[0]), float(size[1])))
    return figure, boxes


def _map_axes(figure: "Figure", box: Box, title: str, shape: tuple[int, int]) -> "Axes":
    """Axes over a whole picture, px, with its title."""
    write_text(figure, box[0], box[1] - 28, title, bold=True, size=SMALL)
    axes = place_axes(figure, *box)
    axes.set_axis_off()
    axes.set_xlim(-0.5, shape[1] - 0.5)
    axes.set_ylim(shape[0] - 0.5, -0.5)
    sides: tuple[tuple[Side, int], ...] = (("below", shape[1]), ("left", shape[0]))
    for side, length in sides:
        Ruler(side, -0.5, length - 0.5, STEPS, SMALL * 0.8, FAINT).draw(figure, box)
    corner = (box[0] - 30, box[1] + box[3] + 6)
    write_text(figure, *corner, "px", size=SMALL * 0.8, colour=FAINT)
    return axes


def _draw_backdrop(axes: "Axes", picture: GreyImage) -> None:
    """Show a grey picture pale, white outside its mask."""
    height, width = picture.shape
    pale = np.where(picture.mask, 0.75 + 0.25 * picture.grey, 1.0).astype(np.float32)
    axes.imshow(
        reduced(pale, PANEL),
        cmap="gray",
        vmin=0,
        vmax=1,
        extent=(-0.5, width - 0.5, height - 0.5, -0.5),
        aspect="auto",
    )


def _draw_map(figure: "Figure", axes: "Axes", box: Box, panel: Panel) -> None:
    """Draw the values in colours and the colour bar beside them."""
    scale = panel.scale or colour_scale(panel.values)
    axes.imshow(
        panel.values,
        cmap=scale.map,
        vmin=scale.low,
        vmax=scale.high,
        extent=panel.extent,
        interpolation="nearest",
        aspect="auto",
    )
    bar = (box[0] + box[2] + 14, box[1], BAR * 0.7, box[3])
    draw_colour_bar(figure, bar, scale, panel.label)


def grid_extent(grid: CorrelationGrid) -> tuple[float, float, float, float]:
    """Outer edges of the cells around the points of a grid, px: left, right, bottom, top."""
    first, last = grid.reference_px[0, 0], grid.reference_px[-1, -1]
    half = grid.spacing / 2
    return (
        float(first[0] - half),
        float(last[0] + half),
        float(last[1] + half),
        float(first[1] - half),
    )


def panels_figure(panels: Sequence[Panel], picture: GreyImage, heading: Heading) -> "Figure":
    """Draw maps over one picture, two in a row."""
    figure, boxes = _panel_grid(len(panels), [picture.shape] * len(panels), heading)
    for panel, box in zip(panels, boxes, strict=True):
        axes = _map_axes(figure, box, panel.title, picture.shape)
        _draw_backdrop(axes, picture)
        _draw_map(figure, axes, box, panel)
    return figure


def correlation_figure(grid: CorrelationGrid, reference: GreyImage) -> "Figure":
    """Map displacement, correlation and status over the reference picture."""
    extent = grid_extent(grid)
    shift = grid.deformed_px - grid.reference_px
    inside = grid.status != PointStatus.OUTSIDE_MASK
    zncc = np.where(inside, grid.zncc, np.nan)
    scale = colour_scale(grid.zncc[grid.status == PointStatus.OK], zncc)
    count = int(np.count_nonzero(inside))
    panels = [
        Panel("Displacement along x", shift[..., 0], extent, "u  [px]"),
        Panel("Displacement along y", shift[..., 1], extent, "v  [px]"),
        Panel("Correlation", zncc, extent, "ZNCC  [–]", scale),
    ]
    note = (
        f"{grid.ok_count} of {count} points ({grid.ok_count / max(1, count):.1%}) have a value; "
        f"subset {grid.subset_size} px, spacing {grid.spacing} px"
    )
    shape = reference.shape
    heading = Heading("Correlation in the reference picture", note)
    figure, boxes = _panel_grid(4, [shape] * 4, heading)
    for panel, box in zip(panels, boxes, strict=False):
        axes = _map_axes(figure, box, panel.title, shape)
        _draw_backdrop(axes, reference)
        _draw_map(figure, axes, box, panel)
    axes = _map_axes(figure, boxes[3], "Status of each point", shape)
    _draw_backdrop(axes, reference)
    _draw_status(axes, grid.status, extent)
    _draw_status_key(figure, boxes[3], grid.status)
    return figure


def _draw_status(axes: "Axes", status: Codes, extent: Box) -> None:
    """Colour every point inside the mask by its status."""
    from matplotlib.colors import to_rgba_array

    table = to_rgba_array([STATUS_COLOURS[code] for code in PointStatus])
    table[PointStatus.OUTSIDE_MASK, 3] = 0.0
    axes.imshow(table[status], extent=extent, interpolation="nearest", aspect="auto")


def _draw_status_key(figure: "Figure", box: Box, status: Codes) -> None:
    """List the statuses that occur, with their colours and counts."""
    counts = count_statuses(status)
    counts.pop(PointStatus.OUTSIDE_MASK.name, None)
    for row, (name, count) in enumerate(counts.items()):
        left, top = box[0] + box[2] + 14, box[1] + 44 * row
        place_patch(figure, (left, top + 2, 14, 14), STATUS_COLOURS[PointStatus[name]])
        write_text(figure, left + 20, top, STATUS_WORDS[PointStatus[name]], size=SMALL * 0.8)
        write_text(figure, left + 20, top + 18, str(count), size=SMALL * 0.8, colour=FAINT)


def distortion_figure(pair: FlattenedPair) -> "Figure":
    """Map what the flattening did to area and shape, for both surfaces."""
    surfaces = (("Reference", pair.reference), ("Deformed", pair.deformed))
    shapes = [surface.calibrated.image.shape for _, surface in surfaces for _ in range(2)]
    note = "σ₁ ≥ σ₂: stretch of each triangle, px per mm; area change 0 and anisotropy 1 are ideal"
    figure, boxes = _panel_grid(4, shapes, Heading("Distortion by the flattening", note))
    for k, (name, surface) in enumerate(surfaces):
        for panel, box in zip(_distortion_panels(name, surface), boxes[2 * k :], strict=False):
            axes = _map_axes(figure, box, panel.title, surface.calibrated.image.shape)
            _draw_map(figure, axes, box, panel)
    return figure


def surface_distortion_figure(name: str, surface: FlattenedSurface) -> "Figure":
    """Map what the flattening did to area and shape of one surface."""
    shape = surface.calibrated.image.shape
    note = "σ₁ ≥ σ₂: stretch of each triangle, px per mm; area change 0 and anisotropy 1 are ideal"
    heading = Heading(f"Distortion by the flattening ({surface.method})", note)
    figure, boxes = _panel_grid(2, [shape] * 2, heading)
    for panel, box in zip(_distortion_panels(name, surface), boxes, strict=True):
        axes = _map_axes(figure, box, panel.title, shape)
        _draw_map(figure, axes, box, panel)
    return figure


def _distortion_panels(name: str, surface: FlattenedSurface) -> list[Panel]:
    """Area change and anisotropy of one surface on its picture."""
    triangle = surface.calibrated.triangle
    height, width = triangle.shape
    step = max(1, int(np.ceil(max(height, width) / PANEL)))
    seen = triangle[::step, ::step]
    extent = (-0.5, width - 0.5, height - 0.5, -0.5)
    first, second = surface.distortion.sigma_1, np.abs(surface.distortion.sigma_2)
    scale = surface.calibrated.chart.px_per_mm
    with np.errstate(divide="ignore"):
        area = np.log2(first * second) - 2 * np.log2(scale)
        ratio = first / second
    labels = ("log₂(σ₁σ₂ / scale²)  [–]", "σ₁ / σ₂  [–]")
    titles = (f"{name}: area change", f"{name}: anisotropy")
    maps = (_seen(area, seen), _seen(ratio, seen))
    scales = (
        colour_scale(maps[0], least=2 * LEAST_DISTORTION),
        colour_scale(maps[1], least=LEAST_DISTORTION),
    )
    return [Panel(*each) for each in zip(titles, maps, [extent] * 2, labels, scales, strict=True)]


def _seen(values: Floats, triangle: np.ndarray[tuple[int, int], np.dtype[np.int32]]) -> Floats:
    """Spread a value per triangle over the pixels that show it."""
    return np.where(triangle >= 0, values[triangle], np.nan)
