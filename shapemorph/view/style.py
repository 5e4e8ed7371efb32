"""How pictures look: colours that everybody can tell apart, type, scale bars."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from shapemorph.core.arrays import Floats, Greys
from shapemorph.core.status import PointStatus
from shapemorph.methods.colour_maps import DIVERGING, SEQUENTIAL, colour_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

    from shapemorph.view.window import Pixels

DPI = 100
INK = "#1d2430"
FAINT = "#6b7280"
PAPER = "#ffffff"
BARE = "#a7abb3"
"""Surface without a value."""
REFERENCE_COLOUR = "#0072b2"
DEFORMED_COLOUR = "#d55e00"
TEXT, SMALL = 15.0, 13.0
"""Sizes of type, points at 100 px per inch."""

STATUS_COLOURS = {
    PointStatus.OK: "#cfe3ef",
    PointStatus.OUTSIDE_MASK: "#ffffff",
    PointStatus.NOT_SEEDED: "#e69f00",
    PointStatus.LEFT_IMAGE: "#56b4e9",
    PointStatus.LOW_CONTRAST: "#f0e442",
    PointStatus.NOT_CONVERGED: "#d55e00",
    PointStatus.LOW_ZNCC: "#cc79a7",
    PointStatus.OUTLIER: "#000000",
    PointStatus.DEGENERATE_FACET: "#009e73",
}

STATUS_WORDS = {
    PointStatus.OK: "OK",
    PointStatus.OUTSIDE_MASK: "outside mask",
    PointStatus.NOT_SEEDED: "not seeded",
    PointStatus.LEFT_IMAGE: "left image",
    PointStatus.LOW_CONTRAST: "low contrast",
    PointStatus.NOT_CONVERGED: "not converged",
    PointStatus.LOW_ZNCC: "low ZNCC",
    PointStatus.OUTLIER: "outlier",
    PointStatus.DEGENERATE_FACET: "degenerate",
}


@dataclass(frozen=True, slots=True)
class ColourScale:
    """Which value has which colour.

    Attributes
    ----------
    name : str
        Of a colour map: viridis for magnitudes, blue-red around zero.
    low, high : float
        Values of the first and the last colour; values beyond have the same ones.
    beyond : str
        "neither", "min", "max" or "both": where values lie beyond.
    """

    name: str
    low: float
    high: float
    beyond: str

    def colours(self, values: Floats) -> np.ndarray[tuple[int, int], np.dtype[np.uint8]]:
        """Colours (N, 3) in [0, 255] of values (N,); grey where NaN."""
        table = colour_table(self.name)
        known = np.isfinite(values)
        share = np.where(known, (values - self.low) / (self.high - self.low), 0.0)
        step = np.clip((share * len(table)).astype(np.int64), 0, len(table) - 1)
        bare = np.round(255 * np.array(rgb_of(BARE))).astype(np.uint8)
        return np.where(known[:, None], table[step], bare)

    @property
    def map(self) -> "Colormap":
        """The same as a matplotlib colour map."""
        from matplotlib.colors import ListedColormap

        return ListedColormap(colour_table(self.name) / 255.0, self.name)


def rgb_of(colour: str) -> tuple[float, ...]:
    """Red, green and blue, 0 to 1, of a colour written as #rrggbb."""
    return tuple(int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))


def colour_scale(values: Floats, shown: Floats | None = None, *, least: float = 0.0) -> ColourScale:
    """Fit a scale to values: the middle 99 %, around zero where both signs matter.

    Parameters
    ----------
    values : array
        What the scale is fitted to; without finite ones it is 0 to 1.
    shown : array or None
        All that will have these colours; None: the same.
    least : float
        Difference between its ends, at least, so that nothing does not look like much.
    """
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        return ColourScale(SEQUENTIAL, 0.0, 1.0, "neither")
    low, high = (float(p) for p in np.percentile(finite, [0.5, 99.5]))
    size = max(abs(low), abs(high))
    if high - low <= 1e-9 * (1 + size):
        room = max(0.01 * size if size > 1e-9 else 1.0, least / 2)
        return ColourScale(SEQUENTIAL, low - room, high + room, "neither")
    name, high = SEQUENTIAL, max(high, low + least)
    if min(-low, high) > 0.05 * size:
        size = max(size, least / 2)
        low, high, name = -size, size, DIVERGING
    return ColourScale(name, low, high, _beyond(finite if shown is None else shown, low, high))


def _beyond(values: Floats, low: float, high: float) -> str:
    """Say at which ends the arrows of a colour bar are needed."""
    under, over = bool((values < low).any()), bool((values > high).any())
    return {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[under, over]


def reduced(picture: Greys, longest: int) -> Greys:
    """Shrink a picture by a whole factor to at most about `longest` px, averaging blocks."""
    step = max(1, int(np.ceil(max(picture.shape) / longest)))
    height, width = (max(1, length // step) * step for length in picture.shape)
    blocks = picture[:height, :width].reshape(height // step, step, width // step, step)
    return np.asarray(blocks.mean(axis=1).mean(axis=2), dtype=np.float32)


def new_figure(width: float, height: float) -> "Figure":
    """Make an empty figure of the given size in px; the caller saves it.

    No pyplot and no window: figures live and die with their variable.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor=PAPER)
    FigureCanvasAgg(figure)
    return figure


def place_axes(figure: "Figure", left: float, top: float, width: float, height: float) -> "Axes":
    """Add axes to a figure, all in px from its upper left corner."""
    across, down = figure.get_size_inches() * DPI
    box = (left / across, 1 - (top + height) / down, width / across, height / down)
    axes = figure.add_axes(box)
    axes.set_title("", y=1.0)  # else each drawing measures all labels to keep titles off them
    return axes


def place_pixels(
    figure: "Figure", left: int, top: int, pixels_at: Callable[[int], "Pixels"]
) -> None:
    """Put a picture into a figure, px of the layout from its upper left corner.

    Parameters
    ----------
    left, top : int
    pixels_at : callable
        Makes the picture (H, W, 3), whose pixels become those of the file; called with
        their number for one px of the layout when the figure is drawn.
    """
    from shapemorph.view.pasted import Pasted

    figure.add_artist(Pasted(left, top, pixels_at))


def place_patch(figure: "Figure", box: tuple[float, float, float, float], colour: str) -> None:
    """Fill a rectangle (left, top, width, height), px from the upper left corner."""
    from matplotlib.patches import Rectangle

    across, down = figure.get_size_inches() * DPI
    left, top, width, height = box
    corner = (left / across, 1 - (top + height) / down)
    patch = Rectangle(
        corner, width / across, height / down, facecolor=colour, edgecolor=FAINT, linewidth=0.8
    )
    patch.set_transform(figure.transFigure)
    figure.add_artist(patch)


def write_text(  # noqa: PLR0913  # where, what, and three ways to look
    figure: "Figure",
    left: float,
    top: float,
    text: str,
    *,
    size: float = TEXT,
    colour: str = INK,
    bold: bool = False,
) -> None:
    """Write one line of text with its upper left corner in px from that of the figure."""
    across, down = figure.get_size_inches() * DPI
    figure.text(
        left / across,
        1 - top / down,
        text,
        va="top",
        fontsize=size,
        color=colour,
        fontweight="bold" if bold else "normal",
    )


def round_length(longest: float) -> float:
    """Largest of 1, 2 or 5 times a power of ten that is not above `longest`."""
    power = 10.0 ** np.floor(np.log10(longest))
    steps = np.array([1.0, 2.0, 5.0]) * power
    return float(steps[steps <= longest * (1 + 1e-9)].max())


def draw_scale_bar(
    figure: "Figure", left: float, top: float, mm_per_px: float, width: float
) -> None:
    """Draw a bar of a round length, and say how long it is.

    Parameters
    ----------
    left, top : float
        px from the upper left corner of the figure.
    mm_per_px : float
    width : float
        Of the picture that it belongs to, px; the bar is at most a quarter as long.
    """
    from matplotlib.lines import Line2D

    across, down = figure.get_size_inches() * DPI
    length = round_length(0.25 * width * mm_per_px)
    ends = np.array([left, left + length / mm_per_px]) / across
    height = 1 - (top + 2) / down
    bar = Line2D(ends, [height, height], color=INK, linewidth=3.5, solid_capstyle="butt")
    bar.set_transform(figure.transFigure)
    figure.add_artist(bar)
    write_text(figure, left, top + 9, f"{length:g} mm", size=SMALL)
