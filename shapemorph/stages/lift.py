"""Stage `lift`: grid positions in two pictures to points in space."""

import numpy as np

from shapemorph.config import LiftConfig
from shapemorph.core.arrays import Bools, Codes, Floats
from shapemorph.core.errors import StageError
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import CalibratedImage, SurfacePoints
from shapemorph.core.mesh import TexturedMesh
from shapemorph.core.status import PointStatus, count_statuses
from shapemorph.core.surface import TrackedSurface
from shapemorph.methods.chart_rim import extend_to
from shapemorph.methods.field_noise import interpolated_noise, position_covariance
from shapemorph.methods.mesh_noise import vertex_noise
from shapemorph.methods.picture_scale import mm_per_px
from shapemorph.methods.surface_lookup import locate, positions
from shapemorph.methods.threads import run_at_once
from shapemorph.methods.vertex_averaging import averaged_noise, leverage_of_cut_subsets
from shapemorph.methods.vertex_normals import normals_at, vertex_normals

_NORMAL_PASSES = 2  # averages over the faces around: about two edges wide
_NOISE_SAMPLES = 2000  # vertices: the median is then known to 2 %
_ROUNDING_PX = 1e-6  # a grid point on the rim itself may fall outside by rounding


def lift(
    reference_mesh: TexturedMesh,
    reference: CalibratedImage,
    deformed_mesh: TexturedMesh,
    deformed: CalibratedImage,
    grid: CorrelationGrid,
    config: LiftConfig,
) -> TrackedSurface:
    """Carry every grid point and its match back to the two surfaces.

    Parameters
    ----------
    reference_mesh, deformed_mesh : TexturedMesh
        mm, each in the frame of its file.
    reference, deformed : CalibratedImage
        Their flattened pictures.
    grid : CorrelationGrid
        Positions in these pictures, px.
    config : LiftConfig

    Returns
    -------
    TrackedSurface
        Points whose match lies off the deformed surface by more than the configured
        distance are LEFT_IMAGE.

    Raises
    ------
    StageError
        If no point has a place on both surfaces.
    """
    reach = max(config.max_extrapolation_px, _ROUNDING_PX)
    sides = (
        (reference, grid.reference_px.reshape(-1, 2), reach),
        (deformed, grid.deformed_px.reshape(-1, 2), config.max_extrapolation_px),
    )
    before, after = run_at_once(lambda side: _placed(*side), sides)
    status = _fates(grid, before, after)
    if not (status == PointStatus.OK).any():
        raise StageError(
            f"expected grid points with a place on both surfaces, got none: "
            f"{count_statuses(status)}: raise lift.max_extrapolation_px, or look at the matches"
        )
    normals, noises = zip(*run_at_once(_faced, (reference_mesh, deformed_mesh)), strict=True)
    noise = np.array(noises)
    shape = grid.status.shape
    lost = (status != PointStatus.OK).ravel()
    sigma_mesh = _sigma_mesh(reference, deformed, grid, noise)
    scales = (
        mm_per_px(reference_mesh, reference.chart, before.face),
        mm_per_px(deformed_mesh, deformed.chart, after.face),
    )
    heights = [
        interpolated_noise(points.barycentric, vertex_noise=vertex)
        for points, vertex in ((before, noise[0]), (after, noise[1]))
    ]
    covariance = position_covariance(
        scales,
        grid.gradient.reshape(-1, 2, 2),
        grid.covariance_px2.reshape(-1, 2, 2),
        sigma_mesh,
    )
    variance = np.trace(covariance, axis1=1, axis2=2) + heights[0] ** 2 + heights[1] ** 2
    return TrackedSurface(
        reference=positions(reference_mesh, before).reshape(*shape, 3),
        deformed=_without(positions(deformed_mesh, after), lost).reshape(*shape, 3),
        reference_normal=normals_at(normals[0], reference_mesh.faces, before).reshape(*shape, 3),
        deformed_normal=_without(normals_at(normals[1], deformed_mesh.faces, after), lost).reshape(
            *shape, 3
        ),
        sigma_position=_without(np.sqrt(variance / 3), lost).reshape(shape),
        status=status,
        mesh_noise=noise,
        sigma_mesh=_without(sigma_mesh, lost).reshape(*shape, 2),
        covariance=_without(covariance.reshape(-1, 9), lost).reshape(*shape, 3, 3),
        sigma_heights=_without(np.stack(heights, axis=1), lost).reshape(*shape, 2),
    )


def _placed(image: CalibratedImage, points_px: Floats, reach: float) -> SurfacePoints:
    return extend_to(image.chart, locate(image, points_px), points_px, reach=reach)


def _fates(grid: CorrelationGrid, before: SurfacePoints, after: SurfacePoints) -> Codes:
    """Statuses, with points that have no place on one of the surfaces taken out."""
    status = grid.status.copy()
    shape = status.shape
    status[(after.face < 0).reshape(shape) & (status == PointStatus.OK)] = PointStatus.LEFT_IMAGE
    status[(before.face < 0).reshape(shape)] = PointStatus.OUTSIDE_MASK
    return status


def _faced(mesh: TexturedMesh) -> tuple[Floats, float]:
    """Find the normals of the vertices of a mesh, and their noise."""
    normals = vertex_normals(mesh.vertices, mesh.faces, passes=_NORMAL_PASSES)
    return normals, vertex_noise(mesh.vertices, mesh.faces, normals, samples=_NOISE_SAMPLES)


def _without(values: Floats, lost: Bools) -> Floats:
    return np.where(lost if values.ndim == 1 else lost[:, None], np.nan, values)


def _sigma_mesh(
    reference: CalibratedImage, deformed: CalibratedImage, grid: CorrelationGrid, noise: Floats
) -> Floats:
    """Tangential noise of the matches due to either mesh, (N, 2), mm."""
    before, after = grid.reference_px.reshape(-1, 2), grid.deformed_px.reshape(-1, 2)
    scale = np.sqrt(np.abs(_determinant(grid.gradient.reshape(-1, 2, 2))))
    width = np.full(len(before), float(grid.subset_size))
    sides = [
        averaged_noise(reference.chart.vertex_px, before, width, vertex_noise=noise[0]),
        averaged_noise(deformed.chart.vertex_px, after, width * scale, vertex_noise=noise[1]),
    ]
    points = np.rint(before).astype(np.int64)
    cut = leverage_of_cut_subsets(reference.image.mask, points, grid.subset_size)
    return np.stack(sides, axis=1) * cut[:, None]


def _determinant(matrices: Floats) -> Floats:
    turns: Floats = matrices[:, 0, 0] * matrices[:, 1, 1] - matrices[:, 0, 1] * matrices[:, 1, 0]
    return turns
