"""A grid of matched points to points in space, and to a mesh with their pattern."""

from dataclasses import replace

import numpy as np

from shapemorph.core.arrays import Floats, Greys, Ints
from shapemorph.core.camera import Rig
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.image import GreyImage
from shapemorph.core.matching import Warp
from shapemorph.core.mesh import TexturedMesh, textured_mesh
from shapemorph.core.reconstruction import Reconstruction
from shapemorph.core.status import PointStatus
from shapemorph.methods.cameras.orientation import epipolar_distance
from shapemorph.methods.cameras.triangulation import triangulate
from shapemorph.methods.morphing import morph_image
from shapemorph.methods.warp_fit import fit_warp_checked
from shapemorph.methods.warping import warp_points

_USUAL = 6.0  # robust standard deviations off the epipolar line
_LEAST_LIMIT = 0.1  # px
_EXACT = 1e-4  # px: the first picture says which point is meant
_KNOTS = 3.0, 1.5  # grid steps, or subsets, between coefficients: neighbours share their noise
_TEXTURE_STIFFNESS = 1e-3
_TORN = 5.0  # times the median edge: a longer one is no surface


def smooth_disparities(grid: CorrelationGrid) -> tuple[CorrelationGrid, float]:
    """Replace the matched positions by a smooth field through them.

    The stiffness of the B-splines is the one that predicts left-out points best.

    Returns
    -------
    CorrelationGrid
    float
        Root mean square by which points have moved, px.

    References
    ----------
    .. [1] Genovese, K.; Sorgente, D. (2017). Opt. Lasers Eng.
       :doi:`10.1016/j.optlaseng.2017.06.020`
    """
    ok = grid.status == PointStatus.OK
    fit = fit_warp_checked(
        grid.reference_px[ok],
        grid.deformed_px[ok],
        extent=_extent(grid),
        spacing=max(_KNOTS[0] * grid.spacing, _KNOTS[1] * grid.subset_size),
        smoothing=None,
        weights=1 / np.maximum((grid.sigma_px[ok] ** 2).sum(axis=1), 1e-12),
    )
    moved = grid.deformed_px.copy()
    moved[ok] = warp_points(fit.warp, grid.reference_px[ok])[0]
    change = moved[ok] - grid.deformed_px[ok]
    return replace(grid, deformed_px=moved), float(np.sqrt((change**2).sum(axis=1).mean()))


def _extent(grid: CorrelationGrid) -> tuple[Floats, Floats]:
    flat = grid.reference_px.reshape(-1, 2)
    return flat.min(axis=0) - grid.spacing, flat.max(axis=0) + grid.spacing


def place_grid(
    rig: Rig, grid: CorrelationGrid, *, limit: float | None, smoothed: float | None
) -> Reconstruction:
    """Triangulate the points of a grid; those off their epipolar lines are lost.

    Parameters
    ----------
    rig : Rig
        Of two cameras.
    grid : CorrelationGrid
        From the first picture into the second.
    limit : float or None
        Farthest that a point may lie off its line, px; None: six times what is usual.
    smoothed : float or None
        What :func:`smooth_disparities` says, if it was applied.
    """
    shape = grid.status.shape
    first, second = grid.reference_px.reshape(-1, 2), grid.deformed_px.reshape(-1, 2)
    off = epipolar_distance(rig, first, second)
    ok = grid.status.ravel() == PointStatus.OK
    if limit is None:
        usual = 1.4826 * float(np.median(off[ok & np.isfinite(off)]))
        limit = max(_USUAL * usual, _LEAST_LIMIT)
    sigma = np.stack([np.full(second.shape, _EXACT), grid.sigma_px.reshape(-1, 2)])
    found = triangulate(rig.cameras, np.stack([first, second]), sigma)
    good = ok & (off <= limit) & np.isfinite(found.points).all(axis=1)
    status = np.where(ok & ~good, np.uint8(PointStatus.OUTLIER), grid.status.ravel())
    for values in (found.points, found.sigma):
        values[~good] = np.nan
    return Reconstruction(
        rig=rig,
        first_px=grid.reference_px,
        second_px=np.where(good[:, None], second, np.nan).reshape(*shape, 2),
        points=found.points.reshape(*shape, 3),
        sigma=found.sigma.reshape(*shape, 3),
        epipolar_px=off.reshape(shape),
        zncc=grid.zncc,
        status=status.reshape(shape),
        spacing=grid.spacing,
        subset_size=grid.subset_size,
        smoothed_px=smoothed,
    )


def mesh_of(found: Reconstruction, left: GreyImage, right: GreyImage) -> TexturedMesh:
    """Make the textured mesh of a reconstruction; grey is the mean of what both cameras saw.

    The texture lies as the first picture does; outer is the side towards the cameras.
    """
    ok = found.status == PointStatus.OK
    number = np.full(ok.shape, -1, dtype=np.int64)
    number[ok] = np.arange(int(ok.sum()))
    vertices = found.points[ok]
    faces = _whole_edges(vertices, _faces(number))
    used = np.unique(faces)
    new = np.full(len(vertices), -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    height, width = left.shape
    pixels = found.first_px[ok][used]
    uv = np.stack([(pixels[:, 0] + 0.5) / width, 1 - (pixels[:, 1] + 0.5) / height], axis=-1)
    faces = new[faces]
    one_texture = np.zeros(len(faces), dtype=np.int64)
    texture = _mean_grey(found, left, right)
    return textured_mesh(vertices[used], faces, uv[faces], one_texture, (texture,), name="mesh")


def _faces(number: Ints) -> Ints:
    """Two triangles for each cell with four corners, one for those with three."""
    a, b = number[:-1, :-1].ravel(), number[:-1, 1:].ravel()
    c, d = number[1:, :-1].ravel(), number[1:, 1:].ravel()
    whole = (a >= 0) & (b >= 0) & (c >= 0) & (d >= 0)
    parts = [np.stack([a, c, b], axis=-1)[whole], np.stack([b, c, d], axis=-1)[whole]]
    for corners in ((a, c, b), (b, c, d), (a, c, d), (a, d, b)):
        triangle = np.stack(corners, axis=-1)
        parts.append(triangle[~whole & (triangle >= 0).all(axis=1)])
    return np.concatenate(parts)


def _whole_edges(vertices: Floats, faces: Ints) -> Ints:
    """Leave out triangles over a step in depth."""
    corners = vertices[faces]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    whole: Ints = faces[edges.max(axis=1) <= _TORN * np.median(edges)]
    return whole


def _mean_grey(found: Reconstruction, left: GreyImage, right: GreyImage) -> Greys:
    warp = _warp_of(found)
    seen = morph_image(right, warp, left.shape)
    mean = np.where(seen.mask, (left.grey + seen.grey) / 2, left.grey)
    return mean.astype(np.float32)


def _warp_of(found: Reconstruction) -> Warp:
    ok = found.status == PointStatus.OK
    height, width = found.first_px.shape[:2]
    size = np.array([width, height]) * float(found.spacing)
    low = found.first_px.reshape(-1, 2).min(axis=0) - found.spacing
    return fit_warp_checked(
        found.first_px[ok],
        found.second_px[ok],
        extent=(low, low + size + 2 * found.spacing),
        spacing=2.0 * found.spacing,
        smoothing=_TEXTURE_STIFFNESS,
    ).warp
