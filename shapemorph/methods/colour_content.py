"""Which colour channel shows the pattern best: that with the most gradient."""

from collections.abc import Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shapemorph.core.arrays import Floats

LUMA = np.array([0.2126, 0.7152, 0.0722])  # Rec. 709, on stored values
CHANNELS = MappingProxyType(
    {
        "luma": LUMA,
        "red": np.array([1.0, 0.0, 0.0]),
        "green": np.array([0.0, 1.0, 0.0]),
        "blue": np.array([0.0, 0.0, 1.0]),
    }
)
TILES, WIDTH = 12, 48  # along each side of a picture; px
BLUR = 1.5  # px: noise of single pixels has little gradient beyond it
FAINT = (0.3 / 255) ** 2  # squared gradient of a tile without a pattern
MUCH_MORE = 2.0  # times the content of luma, which averages the noise of three channels


def gradient_content(colours: NDArray[Any], full: float) -> Floats:
    """Measure how much pattern each channel shows.

    Parameters
    ----------
    colours : (H, W, 3)
        Only differences count.
    full : float
        Their range: grey levels are shares of it.

    Returns
    -------
    (4,)
        Of luma, red, green, blue: the squared gradient of the blurred channel, a mean over
        tiles, the median of those that show a pattern; grey levels^2 / px^2. Zero where
        nothing does.
    """
    weights = np.stack(list(CHANNELS.values()), axis=1)
    tiles = np.array([_tile_content(tile / full @ weights) for tile in _tiles(colours)])
    shown = tiles[tiles.max(axis=1) > FAINT]
    content: Floats = np.median(shown, axis=0) if len(shown) else np.zeros(len(CHANNELS))
    return content


def best_channel(contents: Sequence[Sequence[float]]) -> tuple[str, str]:
    """Choose the channel that several pictures show best, and say why.

    Parameters
    ----------
    contents : sequence of (4,)
        Of each picture, as :func:`gradient_content` gives it; empty for a grey picture.

    Returns
    -------
    channel : str
        luma, unless another has twice its content: the geometric mean over the pictures.
    reason : str
    """
    if any(len(content) == 0 or min(content) < 0 or max(content) == 0 for content in contents):
        return "luma", "not all pictures have colours"
    logarithms = np.log(np.maximum(np.array(contents), 1e-12)).mean(axis=0)
    ratios = np.exp(logarithms - logarithms[0])
    names = list(CHANNELS)
    best = int(np.argmax(ratios))
    shown = ", ".join(f"{n} {r:.2f}" for n, r in zip(names[1:], ratios[1:], strict=True))
    if ratios[best] < MUCH_MORE:
        return "luma", f"no channel has {MUCH_MORE:g} times its gradient content ({shown})"
    return names[best], f"gradient content relative to luma: {shown}"


def _tiles(colours: NDArray[Any]) -> list[Floats]:
    """Pieces spread evenly over a picture."""
    starts = [
        np.unique(np.linspace(0, max(size - WIDTH, 0), TILES).astype(int))
        for size in colours.shape[:2]
    ]
    return [
        np.asarray(colours[r : r + WIDTH, c : c + WIDTH], np.float64)
        for r in starts[0]
        for c in starts[1]
    ]


def _tile_content(channels: Floats) -> Floats:
    """(K,) mean squared gradient of each channel of (H, W, K)."""
    import cv2

    smooth = cv2.GaussianBlur(channels, (0, 0), BLUR)
    along_x, along_y = np.diff(smooth, axis=1), np.diff(smooth, axis=0)
    content: Floats = (along_x**2).mean(axis=(0, 1)) + (along_y**2).mean(axis=(0, 1))
    return content
