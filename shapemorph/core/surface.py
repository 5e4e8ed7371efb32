"""Material points followed in space, and the strain measured between two shapes."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Codes, Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.core.status import PointStatus


@dataclass(frozen=True, slots=True, eq=False)
class TrackedSurface:
    """The same grid of material points before and after deformation.

    Attributes
    ----------
    reference : (R, C, 3) float64
        Positions in mm in the frame of the reference file; NaN only where the point is
        outside the mask of the reference picture.
    deformed : (R, C, 3) float64
        Positions in mm in the frame of the deformed file; NaN exactly where `status` is
        not OK.
    reference_normal, deformed_normal : (R, C, 3) float64
        Unit normals of the two surfaces there; NaN where the position is.
    sigma_position : (R, C) float64
        Standard deviation of one component of the displacement, mm, random part (rms over
        the three components); NaN where not OK.
    status : (R, C) uint8
        A :class:`~shapemorph.core.status.PointStatus` per point.
    mesh_noise : (2,) float64
        Estimated noise of one vertex coordinate of the two meshes, mm.
    sigma_mesh : (R, C, 2) float64 or None
        Standard deviation of one tangential component of the match that the noise of the
        two meshes adds: that of the reference on the reference surface, that of the
        deformed on the deformed surface, mm; NaN where not OK. None: not known, none.
    covariance : (R, C, 3, 3) float64 or None
        Predicted for the deformed position along its surface, in its frame, against the
        true one of the material at the reference position, mm^2; NaN where not OK. None:
        not known.
    sigma_heights : (R, C, 2) float64 or None
        Standard deviations of reference and deformed position along their normals, mm; NaN
        where not OK. None: not known.
    """

    reference: Floats
    deformed: Floats
    reference_normal: Floats
    deformed_normal: Floats
    sigma_position: Floats
    status: Codes
    mesh_noise: Floats
    sigma_mesh: Floats | None = None
    covariance: Floats | None = None
    sigma_heights: Floats | None = None

    def __post_init__(self) -> None:
        shape = self.status.shape
        for name in ("reference", "deformed", "reference_normal", "deformed_normal"):
            got = getattr(self, name).shape
            if got != (*shape, 3):
                raise DataError(f"{name} must be {(*shape, 3)} to match status, got {got}")
        lost = ~np.isfinite(self.deformed).all(axis=-1)
        if not np.array_equal(lost, self.status != PointStatus.OK):
            raise DataError("deformed must be NaN exactly where status is not OK")


@dataclass(frozen=True, slots=True, eq=False)
class StrainField:
    """Green-Lagrange strain on the tangent planes of the reference surface.

    Arrays are NaN where there is no value. Green-Lagrange E = (F^T F - I) / 2 with tensor
    shear; E1 >= E2.

    Attributes
    ----------
    tangent : (R, C, 2, 3) float64
        Orthonormal basis of the reference tangent plane at each point.
    deformed_tangent : (R, C, 2, 3) float64
        Orthonormal basis of the deformed tangent plane.
    gradient : (R, C, 2, 2) float64
        Surface deformation gradient F from the first basis into the second.
    tensor : (R, C, 2, 2) float64
        E in `tangent`.
    e1, e2 : (R, C) float64
        Principal values.
    direction_1, direction_1_deformed : (R, C, 3) float64
        Unit direction of E1 in the two states, in the frames of the two files; NaN where
        E1 - E2 is within its noise.
    sigma_tensor : (R, C, 3) float64
        Standard deviations of E11, E22, E12, random part.
    sigma_e1, sigma_e2 : (R, C) float64
        Standard deviations of the principal values, random part.
    sigma_difference : (R, C) float64
        Standard deviation of E1 - E2, along fixed axes.
    facet_tensor : (R-1, C-1, 2, 2, 2) float64
        E of the two triangles of each cell (lower, upper), each homogeneous, in a basis
        whose first axis follows the grid columns.
    scatter : float
        Scatter of the matches about the fits over the predicted one; the standard
        deviations here are multiplied by it, or by more where the fits leave clearly more,
        those of the tracked surface are not.
    window : int
        Points across the fitting window.
    gauge_px, gauge_mm : float
        Virtual strain gauge: (window - 1) * spacing + subset_size, and the same in mm of
        the reference surface (median).
    """

    tangent: Floats
    deformed_tangent: Floats
    gradient: Floats
    tensor: Floats
    e1: Floats
    e2: Floats
    direction_1: Floats
    direction_1_deformed: Floats
    sigma_tensor: Floats
    sigma_e1: Floats
    sigma_e2: Floats
    sigma_difference: Floats
    facet_tensor: Floats
    scatter: float
    window: int
    gauge_px: float
    gauge_mm: float


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """The rigid motion that lays the deformed shape over the reference.

    Attributes
    ----------
    rotation : (3, 3) float64
    translation : (3,) float64
        ``reference_from_deformed``: x_reference_frame = rotation @ x_deformed_frame + translation.
    method : str
        What carried it: "landmarks", "icp", "points" or a combination; "none".
    rms : float
        Root mean square residual of what carried it, mm.
    residuals : (K,) float64
        Residual of each landmark, mm, or of the carrying points (then a sample of them).
    carried_by : int
        Number of landmarks or points that carried the fit.
    carried_share : float
        Share of the offered landmarks or points that carried it.
    carrying_points : (K,) int64
        Flat indices of the grid points that carried it; empty for landmarks and ICP.
    note : str
        One sentence for the summary: which points carried the fit, where they are.
    """

    rotation: Floats
    translation: Floats
    method: str
    rms: float
    residuals: Floats
    carried_by: int
    carried_share: float
    carrying_points: Ints
    note: str

    @classmethod
    def unmoved(cls) -> "Alignment":
        """Both states are in one frame already."""
        return cls(
            rotation=np.eye(3),
            translation=np.zeros(3),
            method="none",
            rms=0.0,
            residuals=np.zeros(0),
            carried_by=0,
            carried_share=1.0,
            carrying_points=np.zeros(0, dtype=np.int64),
            note="nothing is moved: both states are in one frame",
        )
