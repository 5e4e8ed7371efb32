"""Patterns that repeat, so that a match may be off by a whole repeat."""

import numpy as np

from shapemorph.core.arrays import Floats, Greys
from shapemorph.core.matching import Warp
from shapemorph.methods.contrast import Pattern
from shapemorph.methods.densify import GridSearch, search_grid

ALIKE = 0.4  # correlation of a pattern with itself, one repeat away, that counts
NEAREST = 5.0  # standard deviations of the speckle: no repeat is shorter
FARTHEST = 0.3  # of the shorter side of the picture: no repeat is longer
NEARLY = 0.9  # of the highest likeness: multiples of a repeat are as alike as the repeat
MARGIN = 0.15  # ZNCC that the right place must be better by than the next repeat


def find_repeat(pattern: Pattern, *, std: float) -> Floats | None:
    """Find the shortest shift at which a pattern looks about most like itself.

    Parameters
    ----------
    pattern : Pattern
    std : float
        Standard deviation of its speckle, px.

    Returns
    -------
    (2,) or None
        x, y in px; None if the pattern does not repeat.
    """
    import cv2

    lag = int(FARTHEST * min(pattern.shape))
    inside = pattern.mask.astype(np.float32)
    own = _itself_shifted(pattern.values, lag)
    share = inside.sum() if pattern.mask.all() else _itself_shifted(inside, lag)
    likeness = own / np.maximum(share, 0.1 * inside.sum())
    likeness = likeness / max(float(likeness[lag, lag]), 1e-9)
    y, x = np.mgrid[-lag : lag + 1, -lag : lag + 1]
    far = (np.hypot(x, y) > NEAREST * std) & (np.hypot(x, y) < lag - 1)
    if not far.any():
        return None
    peak = float(likeness[far].max())
    highest = cv2.dilate(likeness, np.ones((3, 3), np.uint8))
    summit = (likeness == highest) & far & (likeness >= NEARLY * peak)
    if peak < ALIKE or not summit.any():
        return None
    row, col = min(np.argwhere(summit), key=lambda place: float(((place - lag) ** 2).sum()))
    return np.array([col - lag, row - lag], np.float64)


def _itself_shifted(values: Greys, lag: int) -> Greys:
    """Multiply a picture by itself, shifted cyclically by up to `lag` px, and add up."""
    power = np.abs(np.fft.rfft2(values)) ** 2
    products = np.roll(np.fft.irfft2(power, values.shape), (lag, lag), axis=(0, 1))
    return np.asarray(products[: 2 * lag + 1, : 2 * lag + 1])


def doubt_of_repeat(
    reference: Pattern, deformed: Pattern, warp: Warp, known: Floats, how: GridSearch, std: float
) -> str:
    """Say why a warp may be off by a whole repeat of the pattern.

    Both ways along the repeat, the deformed picture is searched as if the warp led to the
    next repeat; where that looks nearly as good, the pictures cannot tell which is right.

    Parameters
    ----------
    reference, deformed : Pattern
    warp : Warp
        Reference -> deformed.
    known : (K, 2)
        Points of the reference picture at which the warp is right but for repeats, px.
    how : GridSearch
    std : float
        Standard deviation of the speckle of the reference, px.

    Returns
    -------
    str
        Empty if there is nothing to doubt.
    """
    repeat = find_repeat(reference, std=std)
    if repeat is None:
        return ""
    here = _median_zncc(reference, deformed, warp, known, how)
    away = max(
        _median_zncc(
            reference,
            deformed,
            Warp(warp.coefficients, warp.origin + sign * repeat, warp.spacing),
            known,
            how,
        )
        for sign in (-1.0, 1.0)
    )
    if here - away > MARGIN:
        return ""
    return (
        f"the pattern repeats every {np.linalg.norm(repeat):.0f} px, and one repeat away the "
        f"pictures look nearly as alike (ZNCC {away:.2f}, here {here:.2f}): all may be off by a "
        "whole repeat"
    )


def _median_zncc(
    reference: Pattern, deformed: Pattern, warp: Warp, known: Floats, how: GridSearch
) -> float:
    found = search_grid(reference, deformed, warp, known, how)
    missing = np.zeros(max(found.asked - len(found.zncc), 0))
    return float(np.median(np.concatenate([found.zncc, missing]))) if found.asked else 0.0
