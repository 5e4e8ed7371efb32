"""Nouns of sheet forming: limit curves, cuts through a specimen, domes."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.core.errors import DataError


@dataclass(frozen=True, slots=True, eq=False)
class LimitCurve:
    """A forming-limit curve.

    Attributes
    ----------
    minor, major : (K,) float64
        Principal Hencky strains in the plane of the sheet; minor rises.
    conditions : mapping of str to str
        What its file states: material, thickness, temperature, anything else.
    """

    minor: Floats
    major: Floats
    conditions: Mapping[str, str]

    def __post_init__(self) -> None:
        if len(self.minor) != len(self.major) or len(self.minor) < 2:
            raise DataError(f"a limit curve needs 2 points or more, got {len(self.minor)}")
        if (self.minor[1:] <= self.minor[:-1]).any():
            raise DataError("eps2 of a limit curve must rise from point to point")


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """A plane that cuts a specimen.

    Attributes
    ----------
    point, normal, along : (3,) float64
        mm and unit vectors, in the frame of the reference file; `along` lies in the plane:
        distances along it are what profiles are drawn over.
    """

    point: Floats
    normal: Floats
    along: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Cut:
    """Where a plane cuts the measured surface.

    Attributes
    ----------
    name : str
    plane : Plane
    rows : (K, 2) int64
        Ends of the edges that the plane cuts, as rows of the measurement, in order along
        the cut.
    share : (K,) float64
        Of the way from the first end to the second.
    starts : (K,) bool
        Where another line begins; the cut may consist of several.
    """

    name: str
    plane: Plane
    rows: Ints
    share: Floats
    starts: Bools

    def along_cut(self, values: Floats) -> Floats:
        """Interpolate values (N, ...) of the points of the measurement, (K, ...)."""
        share = self.share.reshape(-1, *(1,) * (values.ndim - 1))
        mixed: Floats = (1 - share) * values[self.rows[:, 0]] + share * values[self.rows[:, 1]]
        return mixed


@dataclass(frozen=True, slots=True, eq=False)
class Forming:
    """What was asked of a measurement beyond the field itself.

    Attributes
    ----------
    curve : LimitCurve or None
    diagram : bool
        Whether a forming-limit diagram is wanted.
    critical : int or None
        Row of the point with the smallest margin, or else of the largest major strain.
    cuts : tuple of Cut
    figures : dict
        For the summary, JSON-able; empty where nothing was asked for.
    """

    curve: LimitCurve | None = None
    diagram: bool = False
    critical: int | None = None
    cuts: tuple[Cut, ...] = ()
    figures: dict[str, Any] = field(default_factory=dict)
