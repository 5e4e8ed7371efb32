"""The measures that pictures show: symbol, full name, unit, values."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Floats
from shapemorph.core.measurement import Measurement


@dataclass(frozen=True, slots=True)
class Measure:
    """A scalar per point.

    Attributes
    ----------
    key : str
        Name of its picture file.
    symbol, name, unit : str
        As labels say them; a dash where it has no unit.
    note : str
        One sentence that defines it.
    two_views : bool
        Whether its picture shows the shape from a second side.
    """

    key: str
    symbol: str
    name: str
    unit: str
    note: str
    two_views: bool = True

    @property
    def label(self) -> str:
        """Symbol and unit, for a colour bar or an axis."""
        return f"{self.symbol}  [{self.unit}]"

    @property
    def title(self) -> str:
        """Full name and symbol."""
        return f"{self.name} {self.symbol}"


_ALONG = "Deformed − reference after alignment, along {} of the reference file."
_STRAIN = "Principal value of E = (FᵀF − I)/2 in the tangent plane of the reference."

MEASURES = (
    Measure("displacement_u", "u", "Displacement", "mm", _ALONG.format("x"), two_views=False),
    Measure("displacement_v", "v", "Displacement", "mm", _ALONG.format("y"), two_views=False),
    Measure("displacement_w", "w", "Displacement", "mm", _ALONG.format("z"), two_views=False),
    Measure("displacement", "|d|", "Length of displacement", "mm", "|d| = √(u² + v² + w²)."),
    Measure("E1", "E₁", "Larger principal Green–Lagrange strain", "–", _STRAIN),
    Measure("E2", "E₂", "Smaller principal Green–Lagrange strain", "–", _STRAIN),
)
"""Each has a picture in the report."""

_SIGMA = "One standard deviation of the random part."
FURTHER_MEASURES = (
    Measure("hencky_1", "ε₁", "Larger principal Hencky strain", "–", "ln λ₁."),
    Measure("hencky_2", "ε₂", "Smaller principal Hencky strain", "–", "ln λ₂."),
    Measure("stretch_1", "λ₁", "Larger principal stretch", "–", "√(1 + 2 E₁)."),
    Measure("stretch_2", "λ₂", "Smaller principal stretch", "–", "√(1 + 2 E₂)."),
    Measure(
        "shear_max", "E₁₂ max", "Largest Green–Lagrange shear", "–", "(E₁ − E₂)/2, tensor shear."
    ),
    Measure("area_ratio", "J", "Ratio of areas", "–", "λ₁ λ₂."),
    Measure(
        *("thickness_strain", "ε₃", "Thickness strain (Hencky)", "–"),
        "−(ε₁ + ε₂), for constant volume.",
    ),
    Measure(
        *("sigma_displacement", "σ(u)", "Uncertainty of displacement", "mm"),
        "One standard deviation of one component, random part.",
    ),
    Measure("sigma_E1", "σ(E₁)", "Uncertainty of strain E₁", "–", _SIGMA),
    Measure("sigma_E2", "σ(E₂)", "Uncertainty of strain E₂", "–", _SIGMA),
    Measure(
        *("zncc", "ZNCC", "Correlation of the subsets", "–"),
        "Zero-mean normalised cross-correlation; 1 is best.",
    ),
)
"""Shown by the interactive view alone."""

ON_REQUEST = (
    Measure("limit_margin", "Δε₁", "Margin to the limit curve", "–", "limit(ε₂) − ε₁, Hencky."),
    Measure("thickness", "t", "Thickness", "mm", "t = t₀ exp(ε₃), constant volume."),
)
"""Measures that are only there where they are asked for."""


def measures_in(measurement: Measurement) -> tuple[Measure, ...]:
    """All measures that a measurement has values of."""
    return (*MEASURES, *(m for m in ON_REQUEST if m.key in measurement.arrays))


def measure_of(array: str) -> Measure | None:
    """Find the measure of a scalar array, or of ``u``, ``v``, ``w``; None: it has none."""
    key = f"displacement_{array}" if array in ("u", "v", "w") else array
    everything = (*MEASURES, *FURTHER_MEASURES, *ON_REQUEST)
    return next((measure for measure in everything if measure.key == key), None)


def measure_values(measurement: Measurement, measure: Measure) -> Floats:
    """Values (N,) of a measure at every point, NaN where lost."""
    component = {"displacement_u": 0, "displacement_v": 1, "displacement_w": 2}.get(measure.key)
    displacement = measurement.arrays["displacement"]
    if component is not None:
        return np.asarray(displacement[:, component], dtype=np.float64)
    if measure.key == "displacement":
        return np.asarray(np.linalg.norm(displacement, axis=1), dtype=np.float64)
    return np.asarray(measurement.arrays[measure.key], dtype=np.float64)
