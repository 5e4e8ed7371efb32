"""The regular grid of points that correlation follows."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Codes, Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.core.status import PointStatus


@dataclass(frozen=True, slots=True, eq=False)
class CorrelationGrid:
    """Where every point of a regular grid of the reference picture went.

    Attributes
    ----------
    reference_px : (R, C, 2) float64
        Grid positions, whole multiples of `spacing`, always finite.
    deformed_px : (R, C, 2) float64
        Matched positions in the deformed picture; NaN exactly where `status` is not OK.
    gradient : (R, C, 2, 2) float64
        d deformed_px[i] / d reference_px[j] at the point; NaN likewise.
    zncc : (R, C) float64
        Zero-mean normalised cross-correlation at the solution, 1 is best; may be finite
        for lost points (it says why they were lost).
    iterations : (R, C) int64
    sigma_px : (R, C, 2) float64
        Random standard deviation of `deformed_px`, 1 sigma; NaN where not OK.
    status : (R, C) uint8
        A :class:`~shapemorph.core.status.PointStatus` per point.
    spacing, subset_size : int
        px.
    kernel_seconds : float
        Time of the correlation kernel: Hessians and all iterations.
    bias_px : (R, C, 2) float64 or None
        Estimated systematic error of `deformed_px`, estimate - truth; NaN where it is not
        known. None where it was not estimated at all.
    shared_px2 : (R, C) float64 or None
        Random covariance of the x and the y component of `deformed_px`; NaN where not OK.
        None: it was not estimated and is taken for 0.
    smoothing : float
        How finely the pictures were warped by what a first search had found: standard
        deviation of the averaging weights, in subsets; 0: they were not.
    """

    reference_px: Floats
    deformed_px: Floats
    gradient: Floats
    zncc: Floats
    iterations: Ints
    sigma_px: Floats
    status: Codes
    spacing: int
    subset_size: int
    kernel_seconds: float
    bias_px: Floats | None = None
    shared_px2: Floats | None = None
    smoothing: float = 0.0

    def __post_init__(self) -> None:
        shape = self.status.shape
        expected = {
            "reference_px": (*shape, 2),
            "deformed_px": (*shape, 2),
            "gradient": (*shape, 2, 2),
            "zncc": shape,
            "iterations": shape,
            "sigma_px": (*shape, 2),
        }
        if self.bias_px is not None:
            expected["bias_px"] = (*shape, 2)
        if self.shared_px2 is not None:
            expected["shared_px2"] = shape
        for name, wanted in expected.items():
            got = getattr(self, name).shape
            if got != wanted:
                raise DataError(f"{name} must be {wanted} to match status, got {got}")
        lost = ~np.isfinite(self.deformed_px).all(axis=-1)
        if not np.array_equal(lost, self.status != PointStatus.OK):
            raise DataError("deformed_px must be NaN exactly where status is not OK")

    @property
    def covariance_px2(self) -> Floats:
        """Random covariance of `deformed_px`, (R, C, 2, 2); NaN where not OK."""
        covariance = self.sigma_px[..., None] ** 2 * np.eye(2)
        if self.shared_px2 is not None:
            covariance[..., 0, 1] = covariance[..., 1, 0] = self.shared_px2
        return covariance

    @property
    def ok_count(self) -> int:
        """Number of points with a value."""
        return int(np.count_nonzero(self.status == PointStatus.OK))
