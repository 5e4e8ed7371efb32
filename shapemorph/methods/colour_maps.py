"""Colour maps in which equal steps of a value look equally large, for any colour vision."""

from functools import cache

import numpy as np
from numpy.polynomial.chebyshev import chebval
from numpy.typing import NDArray

from shapemorph.core.arrays import Floats

SEQUENTIAL, DIVERGING = "viridis", "blue-red"
_STEPS = 256
_MIDDLE, _END, _CHROMA = 0.93, 0.42, 0.17
"""Lightness of the middle and of both ends of the diverging map, chroma of its ends."""
_BLUE, _RED = np.deg2rad(258.0), np.deg2rad(32.0)
"""Hues of its ends: blue and orange-red differ for every kind of colour vision."""

_VIRIDIS = np.array(
    [
        [0.4087, 0.5187, 0.3759],
        [0.2983, 0.4547, -0.1467],
        [0.2550, -0.0574, -0.1707],
        [0.0802, -0.0049, 0.0211],
        [-0.0331, -0.0085, 0.0148],
        [-0.0197, 0.0007, 0.0288],
        [-0.0017, 0.0022, 0.0147],
        [0.0066, 0.0008, 0.0048],
        [0.0021, -0.0003, 0.0041],
        [-0.0036, 0.0001, 0.0011],
        [-0.0014, 0.0002, -0.0007],
        [0.0018, -0.0003, -0.0010],
        [0.0010, 0.0003, -0.0011],
        [-0.0007, -0.0003, -0.0009],
        [-0.0006, 0.0002, -0.0006],
        [0.0002, -0.0001, -0.0003],
        [0.0004, 0.0001, -0.0001],
    ]
)
"""Chebyshev coefficients (17, 3) of red, green and blue: viridis (S. van der Walt and N. Smith,
2015) to a fifth of a level of 256, without loading what draws."""

_LMS_FROM_OKLAB = np.array(
    [
        [1.0, 0.3963377774, 0.2158037573],
        [1.0, -0.1055613458, -0.0638541728],
        [1.0, -0.0894841775, -1.2914855480],
    ]
)
_RGB_FROM_LMS = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)
"""Ottosson, "A perceptual color space for image processing" (2020)."""


@cache
def colour_table(name: str) -> NDArray[np.uint8]:
    """Colours (256, 3) of a map in [0, 255], as :func:`colours_of`."""
    table: NDArray[np.uint8] = np.round(255 * colours_of(name)).astype(np.uint8)
    return table


@cache
def colours_of(name: str) -> Floats:
    """Colours (256, 3) of a map, sRGB in [0, 1], from its lower to its upper end.

    Parameters
    ----------
    name : str
        "viridis" or "blue-red", whose lightness falls evenly from its middle.
    """
    if name == DIVERGING:
        return _diverging()
    if name != SEQUENTIAL:
        raise ValueError(f"expected {SEQUENTIAL} or {DIVERGING}, got {name!r}")
    colours: Floats = np.clip(chebval(np.linspace(-1.0, 1.0, _STEPS), _VIRIDIS).T, 0.0, 1.0)
    return colours


def _diverging() -> Floats:
    """Straight lines in Oklab from a light grey to blue and to red, so that steps are equal."""
    side = np.linspace(-1.0, 1.0, _STEPS)
    hue = np.where(side < 0, _BLUE, _RED)
    chroma = _CHROMA * np.abs(side)
    lightness = _MIDDLE + (_END - _MIDDLE) * np.abs(side)
    return _encoded(np.stack([lightness, chroma * np.cos(hue), chroma * np.sin(hue)], axis=1))


def _encoded(oklab: Floats) -> Floats:
    """Turn Oklab (N, 3) into sRGB (N, 3) in [0, 1]."""
    linear = np.clip((oklab @ _LMS_FROM_OKLAB.T) ** 3 @ _RGB_FROM_LMS.T, 0.0, 1.0)
    low = linear <= 0.0031308
    return np.asarray(np.where(low, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055))
