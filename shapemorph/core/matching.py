"""Matched features and the smooth warps through them."""

from dataclasses import dataclass

from shapemorph.core.arrays import Floats
from shapemorph.core.errors import DataError, StageError


@dataclass(frozen=True, slots=True, eq=False)
class Warp:
    """A smooth map of one picture's points onto another's: a uniform cubic B-spline.

    Attributes
    ----------
    coefficients : (R, C, 2) float64
        B-spline coefficients of the target position (x, y), px. Coefficient [r, c] sits at
        source position ``origin + spacing * (c, r)``.
    origin : (2,) float64
        Source position (x, y) of coefficient [0, 0], px.
    spacing : float
        Distance between coefficients, px of the source.
    """

    coefficients: Floats
    origin: Floats
    spacing: float

    def __post_init__(self) -> None:
        if self.coefficients.ndim != 3 or self.coefficients.shape[2] != 2:
            raise DataError(f"coefficients must be (R, C, 2), got {self.coefficients.shape}")
        if min(self.coefficients.shape[:2]) < 4:
            raise DataError("a cubic warp needs at least 4 x 4 coefficients")


@dataclass(frozen=True, slots=True, eq=False)
class Matches:
    """Pairs of points that show the same material, and what was tried to find them.

    Attributes
    ----------
    reference_px, deformed_px : (N, 2) float64
        Positions in the two pictures, px.
    forward : Warp
        Reference -> deformed.
    backward : Warp
        Deformed -> reference.
    counts : dict of str to int
        Points left after each step, in order, for messages and the report.
    settled_px : float
        Median change of the warp in the last round, px.
    residual_px : float
        Median distance of the pairs from the warp, each predicted without itself, px.
    fold_share : float
        Share of the covered area where the warp turns the picture over; 0 when sound.
    doubt : str
        Why the matches may be wrong although they agree with each other; empty when sound.
    manner : str
        What had to be done to find the first pairs; empty the usual way.
    """

    reference_px: Floats
    deformed_px: Floats
    forward: Warp
    backward: Warp
    counts: dict[str, int]
    settled_px: float
    residual_px: float
    fold_share: float
    doubt: str = ""
    manner: str = ""

    def __post_init__(self) -> None:
        if self.reference_px.shape != self.deformed_px.shape:
            raise DataError("matches come in pairs")


class UnmatchedError(StageError):
    """Two pictures could not be matched.

    Attributes
    ----------
    reference_px, deformed_px : (N, 2) float64
        Features that look alike, right or wrong, px: what there is to be shown.
    """

    def __init__(self, message: str, reference_px: Floats, deformed_px: Floats) -> None:
        super().__init__(message)
        self.reference_px = reference_px
        self.deformed_px = deformed_px
