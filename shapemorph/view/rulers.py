"""Numbers along the sides of pictures and colour bars.

matplotlib's own axes make five objects for each number and measure each several times in
every drawing. Here a side is one path and a number is one text.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.view.style import DPI

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.text import Text

Side = Literal["left", "right", "below"]
Box = tuple[float, float, float, float]
"""Left, top, width and height, px from the upper left corner of the figure."""

TICK, PAD = 5.0, 4.0
"""Length of a tick, room between it and its number, px."""
ABOVE, BENEATH = 8.0, 34.0
"""Where the common power of ten stands: above a side, or below the numbers, px."""
STEPS = (1, 2, 2.5, 5, 10)
ANCHORS = {
    "left": ("right", "center_baseline"),
    "right": ("left", "center_baseline"),
    "below": ("center", "top"),
}
"""Which end of a number stands at its tick, by side."""


def round_numbers(low: float, high: float, count: int) -> tuple[Floats, list[str], str]:
    """Choose round numbers between two values, and write them.

    Parameters
    ----------
    low, high : float
        low < high.
    count : int
        Steps between them, at most.

    Returns
    -------
    values : (N,) float64
    words : list of str
        As short as tells them apart.
    power : str
        What all of them are to be multiplied by; empty for 1.
    """
    from matplotlib.ticker import MaxNLocator, ScalarFormatter

    values = np.asarray(MaxNLocator(nbins=count, steps=STEPS).tick_values(low, high))
    slack = 1e-9 * (high - low)
    values = values[(values >= low - slack) & (values <= high + slack)]
    formatter: Any = ScalarFormatter(useOffset=False)
    formatter.create_dummy_axis()
    formatter.axis.set_view_interval(low, high)
    words = formatter.format_ticks(values)
    return np.asarray(values, dtype=np.float64), words, formatter.get_offset()


@dataclass(frozen=True, slots=True)
class Ruler:
    """The numbers of one side of a box.

    Attributes
    ----------
    side : {"left", "right", "below"}
    first, last : float
        Values at its left and right end, or at its top and bottom one; not equal.
    count : int
        Steps between the numbers, at most.
    size : float
        Of the type, points at 100 px per inch.
    colour : str
    """

    side: Side
    first: float
    last: float
    count: int
    size: float
    colour: str

    def draw(self, figure: "Figure", box: Box) -> float:
        """Draw ticks and numbers along the box.

        Returns
        -------
        float
            How far they reach from it, px.
        """
        low, high = sorted((self.first, self.last))
        values, words, power = round_numbers(low, high, self.count)
        along, out = self._places(box, (values - self.first) / (self.last - self.first))
        self._draw_ticks(figure, along, along + TICK * out)
        horizontal, vertical = ANCHORS[self.side]
        below, reach = self.side == "below", 0.0
        for place, word in zip(along + (TICK + PAD) * out, words, strict=True):
            text = write_at(figure, place, word, size=self.size, colour=self.colour)
            text.set(ha=horizontal, va=vertical)
            seen = text.get_window_extent()
            reach = max(reach, seen.height if below else seen.width)
        if power:
            left, top, width, height = box
            place = np.array(
                [left + width, top + height + BENEATH] if below else [left, top - ABOVE]
            )
            write_at(figure, place, power, size=self.size, colour=self.colour)
        return TICK + PAD + reach * DPI / figure.dpi

    def _places(self, box: Box, share: Floats) -> tuple[Floats, Floats]:
        """Feet of the ticks (N, 2), px from the upper left corner, and their direction (2,)."""
        left, top, width, height = box
        if self.side == "below":
            along = np.column_stack([left + share * width, np.full(len(share), top + height)])
            return along, np.array([0.0, 1.0])
        right = self.side == "right"
        edge = np.full(len(share), left + width if right else left)
        return np.column_stack([edge, top + share * height]), np.array([2.0 * right - 1.0, 0.0])

    def _draw_ticks(self, figure: "Figure", feet: Floats, heads: Floats) -> None:
        from matplotlib.collections import LineCollection

        ends = np.stack([share_of(figure, feet), share_of(figure, heads)], axis=1)
        lines = LineCollection(list(ends), colors=self.colour, linewidths=0.8)
        lines.set_transform(figure.transFigure)
        figure.add_artist(lines)


def share_of(figure: "Figure", places: Floats) -> Floats:
    """Turn px (..., 2) from the upper left corner into shares from the lower left one."""
    shares: Floats = np.array([0.0, 1.0]) + places / (figure.get_size_inches() * DPI) * [1.0, -1.0]
    return shares


def write_at(figure: "Figure", place: Floats, words: str, *, size: float, colour: str) -> "Text":
    """Write words whose left end of the baseline is at `place`, px from the upper left corner."""
    x, y = share_of(figure, place)
    return figure.text(float(x), float(y), words, fontsize=size, color=colour)
