"""Morph laws: what they are given, and how far results of several of them differ; variants."""

from dataclasses import dataclass

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.core.landmarks import Landmarks
from shapemorph.core.matching import Warp


@dataclass(frozen=True, slots=True, eq=False)
class Dots:
    """Marks seen in both pictures.

    Attributes
    ----------
    reference_px, deformed_px : (K, 2) float64
        Positions in the two pictures, px.
    """

    reference_px: Floats
    deformed_px: Floats

    def __post_init__(self) -> None:
        if self.reference_px.shape != self.deformed_px.shape or self.reference_px.shape[1:] != (2,):
            raise DataError(
                f"dots come in pairs of (K, 2), got {self.reference_px.shape} and "
                f"{self.deformed_px.shape}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class RadialProfile:
    """Where a finite element model of revolution sends each radius.

    Attributes
    ----------
    material : (K,) float64
        Radius before, mm, rising.
    radius, height : (K,) float64
        Radius and position along the axis after, mm.
    """

    material: Floats
    radius: Floats
    height: Floats


@dataclass(frozen=True, slots=True, eq=False)
class NodalField:
    """Where a finite element model sends each of its nodes.

    Attributes
    ----------
    nodes : (N, 3) float64
        Positions before, mm, in the frame of the reference file.
    displacement : (N, 3) float64
        mm.
    """

    nodes: Floats
    displacement: Floats


@dataclass(frozen=True, slots=True, eq=False)
class LawInputs:
    """What morph laws read beside pictures and matches; None where no law asks for it.

    Attributes
    ----------
    landmarks : Landmarks or None
    dots : Dots or None
    finite_elements : RadialProfile, NodalField or None
    """

    landmarks: Landmarks | None = None
    dots: Dots | None = None
    finite_elements: RadialProfile | NodalField | None = None


@dataclass(frozen=True, slots=True)
class Variant:
    """The same pair measured in another way, against the main result.

    Attributes
    ----------
    name : str
        What was changed: "flatten.method=lscm".
    compared : int
        Points of the main result that have a value in both.
    rms, p95 : float
        Distance of the deformed positions, mm.
    e1_rms, e2_rms : float
        Difference of the principal Green-Lagrange strains.
    """

    name: str
    compared: int
    rms: float
    p95: float
    e1_rms: float
    e2_rms: float


@dataclass(frozen=True, slots=True, eq=False)
class LawSpread:
    """Results of several morph laws against those of the first.

    Attributes
    ----------
    laws : tuple of str
        The main law first; empty where only one law ran.
    warps : tuple of Warp
        What each law says by itself, reference -> deformed, px.
    off_px : (L,) float64
        Median distance between what each law says and what was measured with it, px of
        the deformed picture.
    compared : (L,) int64
        Points that have a value with this law and with the main one.
    rms, p95 : (L,) float64
        Distance of the deformed positions from those of the main law, mm.
    failures : dict of str to str
        Laws and variants that led to nothing, and why.
    variants : tuple of Variant
        Other flattenings and subsets.
    """

    laws: tuple[str, ...]
    warps: tuple[Warp, ...]
    off_px: Floats
    compared: Ints
    rms: Floats
    p95: Floats
    failures: dict[str, str]
    variants: tuple[Variant, ...] = ()
