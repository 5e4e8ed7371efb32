"""Figures of rendered views: pictures in a row, their scale bars, one colour bar."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from shapemorph.view.colour_bar import draw_colour_bar
from shapemorph.view.render import Picture
from shapemorph.view.style import (
    DPI,
    FAINT,
    SMALL,
    ColourScale,
    draw_scale_bar,
    new_figure,
    place_pixels,
    write_text,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EDGE, GAP, HEAD, FOOT = 24, 48, 96, 56
"""Margin, room between panels, above and below them, px."""
BAR, BAR_ROOM, BAR_HEIGHT = 22, 130, 360
"""Width of a colour bar, that with its labels, and its largest height, px."""
TITLE = 18.0
"""Size of type of a title, points at 100 px per inch."""
BOLD, PLAIN = 0.66 * DPI / 72, 0.53 * DPI / 72
"""Mean width of a character in a line of text, px for each point of its size."""


@dataclass(frozen=True, slots=True)
class Heading:
    """What stands above a figure.

    Attributes
    ----------
    title : str
        Full name of what is shown.
    note : str
        One line more.
    """

    title: str
    note: str

    @property
    def width(self) -> int:
        """Room that both lines need, with their margins, px."""
        lines = BOLD * TITLE * len(self.title), PLAIN * SMALL * len(self.note)
        return 2 * EDGE + round(max(lines))


def write_heading(figure: "Figure", heading: Heading) -> None:
    """Write title and note at the upper left."""
    write_text(figure, EDGE, EDGE, heading.title, size=TITLE, bold=True)
    write_text(figure, EDGE, EDGE + 36, heading.note, colour=FAINT, size=SMALL)


def views_figure(
    pictures: Sequence[Picture],
    captions: Sequence[str],
    heading: Heading,
    *,
    scale: ColourScale | None,
    label: str,
) -> "Figure":
    """Put rendered views side by side, with one colour bar where there is a scale.

    Parameters
    ----------
    pictures, captions : sequences of one length
        Each picture gets its own scale bar.
    heading : Heading
    scale : ColourScale or None
        Of all pictures.
    label : str
        Of the colour bar.
    """
    height = max(picture.height for picture in pictures)
    across = sum(picture.width + GAP for picture in pictures) - GAP
    room = BAR_ROOM if scale is not None else 0
    figure = new_figure(max(heading.width, 2 * EDGE + across + room), HEAD + height + FOOT)
    write_heading(figure, heading)
    left = EDGE
    for picture, caption in zip(pictures, captions, strict=True):
        _place_view(figure, picture, caption, left, HEAD, height)
        left += picture.width + GAP
    if scale is not None:
        tall = min(height, BAR_HEIGHT)
        bar = (left - GAP + 24.0, HEAD + (height - tall) / 2, BAR, tall)
        draw_colour_bar(figure, bar, scale, label)
    return figure


def _place_view(
    figure: "Figure", picture: Picture, caption: str, left: int, top: int, height: int
) -> None:
    """Draw one picture, standing on the floor of its row, with scale bar and caption."""
    tall, wide = picture.height, picture.width
    place_pixels(figure, left, top + height - tall, lambda _: picture.pixels)
    draw_scale_bar(figure, left, top + height + 14, picture.mm_per_px, wide)
    write_text(figure, left + 0.35 * wide, top + height + 18, caption, size=SMALL, colour=FAINT)
