"""Forming-limit diagrams: how far points are from a curve, and whether it is meant for them."""

import re

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.forming import LimitCurve

_ALIKE_THICKNESS = 0.1  # relative difference: limits change by some 2 % for such a tenth
_ALIKE_TEMPERATURE = 10.0  # C
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")


def limit_margin(curve: LimitCurve, minor: Floats, major: Floats) -> Floats:
    """Measure how much major strain is left before a forming-limit curve is reached.

    Parameters
    ----------
    curve : LimitCurve
    minor, major : (N,)
        Principal Hencky strains.

    Returns
    -------
    (N,)
        limit(minor) - major, between the points of the curve linear; NaN where the minor
        strain lies beyond its ends: it says nothing there.
    """
    limit = np.interp(minor, curve.minor, curve.major, left=np.nan, right=np.nan)
    margin: Floats = limit - major
    return margin


def margin_noise(curve: LimitCurve, minor: Floats, noise: tuple[Floats, Floats, Floats]) -> Floats:
    """Propagate noise of the strains to the margin.

    Parameters
    ----------
    curve : LimitCurve
    minor : (N,)
        Minor Hencky strain.
    noise : three of (N,)
        Standard deviations of major and minor Hencky strain and of their sum.

    Returns
    -------
    (N,)
        NaN beyond the ends of the curve.
    """
    major_noise, minor_noise, sum_noise = noise
    slopes = np.diff(curve.major) / np.diff(curve.minor)
    piece = np.clip(np.searchsorted(curve.minor, minor) - 1, 0, len(slopes) - 1)
    within = (minor >= curve.minor[0]) & (minor <= curve.minor[-1])
    slope = np.where(within, slopes[piece], np.nan)
    covariance = (sum_noise**2 - major_noise**2 - minor_noise**2) / 2
    variance = major_noise**2 + (slope * minor_noise) ** 2 - 2 * slope * covariance
    noisy: Floats = np.sqrt(np.maximum(variance, 0))
    return noisy


def caveats(
    curve: LimitCurve, *, material: str | None, thickness: float | None, temperature: float | None
) -> tuple[str, ...]:
    """Say where a limit curve may not be meant for a specimen.

    Parameters
    ----------
    curve : LimitCurve
    material, thickness, temperature
        Of the specimen; mm and C; None: unknown.

    Returns
    -------
    tuple of str
        A sentence for each condition that differs or is unknown on either side.
    """
    stated = {key.lower().split("_")[0].split(" ")[0]: v for key, v in curve.conditions.items()}
    pairs = (
        ("material", stated.get("material"), material, _same_name),
        ("thickness", stated.get("thickness"), _text(thickness, "mm"), _near_thickness),
        ("temperature", stated.get("temperature"), _text(temperature, "C"), _near_temperature),
    )
    found = []
    for name, of_curve, of_specimen, alike in pairs:
        if not of_curve or not of_specimen:
            sides = [
                side for side, text in (("curve", of_curve), ("specimen", of_specimen)) if not text
            ]
            found.append(f"the {name} of the {' and of the '.join(sides)} is not known")
        elif not alike(of_curve, of_specimen):
            found.append(f"{name}: the curve is for {of_curve}, the specimen has {of_specimen}")
    return tuple(found)


def _text(value: float | None, unit: str) -> str | None:
    return None if value is None else f"{value:g} {unit}"


def _same_name(one: str, other: str) -> bool:
    return re.sub(r"\W", "", one).casefold() == re.sub(r"\W", "", other).casefold()


def _near_thickness(one: str, other: str) -> bool:
    first, second = _number(one), _number(other)
    return abs(first - second) <= _ALIKE_THICKNESS * max(first, second)


def _near_temperature(one: str, other: str) -> bool:
    return abs(_number(one) - _number(other)) <= _ALIKE_TEMPERATURE


def _number(text: str) -> float:
    """First number of a text; NaN, which is near nothing, without one."""
    found = _NUMBER.search(text)
    return float(found[0]) if found else float("nan")
