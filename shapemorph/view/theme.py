"""Pictures for the screen, or for paper."""

import base64
import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from shapemorph.view.png_file import png_content
from shapemorph.view.style import DPI, FAINT, INK
from shapemorph.view.window import Pixels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WEBP_EFFORT, _WEBP_LONGEST = 50, 16383  # more effort gains nothing; px, by the format
_QUICK, _SMALL = 1, 6  # levels of zlib: the second takes three times as long


@dataclass(frozen=True, slots=True)
class Theme:
    """How figures are written.

    Attributes
    ----------
    pixel_ratio : int
        Pixels of the file for each pixel of the layout.
    inks : mapping of str to str
        What becomes of the colours of the text.
    is_small : bool
        Whether time is spent on making files small.
    """

    pixel_ratio: int
    inks: Mapping[str, str]
    is_small: bool


THEMES = {
    "light": Theme(1, {}, is_small=False),
    "print": Theme(2, {INK: "#000000", FAINT: "#262626"}, is_small=True),
}
"""By their names in the configuration."""


def drawn(figure: "Figure", theme: Theme) -> Pixels:
    """Draw a figure, (H, W, 3)."""
    figure.set_dpi(DPI * theme.pixel_ratio)
    if theme.inks:
        _change_inks(figure, theme.inks)
    canvas: Any = figure.canvas
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3]


def png(pixels: Pixels, theme: Theme) -> bytes:
    """Content of the PNG file of a figure that was drawn."""
    return png_content(pixels, DPI * theme.pixel_ratio, _SMALL if theme.is_small else _QUICK)


def embedded(content: bytes, theme: Theme) -> tuple[str, int]:
    """Turn the content of a PNG file into an address that holds the picture.

    A theme of small files takes WebP without loss, which shows the same pixels and is little
    more than half as large, but takes four times the time.

    Returns
    -------
    source : str
        A ``data:`` address.
    width : int
        px.
    """
    from PIL import Image

    kind = "png"
    with Image.open(io.BytesIO(content)) as picture:
        if theme.is_small and max(picture.size) <= _WEBP_LONGEST:
            kind, buffer = "webp", io.BytesIO()
            picture.save(buffer, "WEBP", lossless=True, quality=_WEBP_EFFORT, method=1)
            content = buffer.getvalue()
        return (
            f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}",
            picture.width,
        )


def _change_inks(figure: "Figure", inks: Mapping[str, str]) -> None:
    """Give every text another colour; a first drawing makes those of the axes."""
    from matplotlib.colors import to_hex
    from matplotlib.text import Text

    figure.draw_without_rendering()
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        colour = to_hex(text.get_color())
        text.set_color(inks.get(colour, colour))
