"""Strain of a plane specimen by local least squares on the grid of its picture."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.grid import CorrelationGrid
from shapemorph.core.planar import PlanarStrain
from shapemorph.core.status import PointStatus
from shapemorph.methods.grid_windows import Windows, connected_windows
from shapemorph.methods.principal import hencky_of, principal
from shapemorph.methods.quadratic_fit import quadratic_operators

CHUNK_POINTS = 2_000_000  # window points fitted at a time: bounds memory to some 100 MB


def planar_strain(grid: CorrelationGrid, *, window: int) -> PlanarStrain:
    """Measure strain from the displacements of a grid.

    Displacements are fitted by quadratics over a window of points around each point (the
    slopes at the centre are those of a plane where the window is full); near rims and
    holes the window grows until it holds as many points as a full one, at most to twice
    its radius, and never reaches across a gap.

    Parameters
    ----------
    grid : CorrelationGrid
    window : int
        Points across the fitting window, odd.

    Returns
    -------
    PlanarStrain
        NaN where a point is lost, or the points of its window do not settle a plane.

    Notes
    -----
    Exact for a homogeneous deformation of any size; a rigid motion gives zero to
    rounding. The points of a window form few patterns, most of them the full square: each
    is solved once.
    """
    usable = grid.status == PointStatus.OK
    gradient = np.full((usable.size, 2, 2), np.nan)
    matched = grid.deformed_px.reshape(-1, 2)
    for windows in connected_windows(usable, window=window, chunk=CHUNK_POINTS // window**2):
        slopes, pattern = _slopes(windows, grid.spacing)
        around = matched[windows.neighbours] - matched[windows.centres][:, None]
        around[~windows.inside] = 0.0
        gradient[windows.centres] = np.einsum("njk,nki->nij", slopes[pattern], around)
    gradient = gradient.reshape(*usable.shape, 2, 2)
    return strain_of(gradient, window=window, gauge_px=gauge_length(grid, window=window))


def gauge_length(grid: CorrelationGrid, *, window: int) -> float:
    """Virtual strain gauge, px: (window - 1) * spacing + subset size."""
    return float((window - 1) * grid.spacing + grid.subset_size)


def strain_of(gradient: Floats, *, window: int, gauge_px: float) -> PlanarStrain:
    """Turn deformation gradients (R, C, 2, 2) into strains."""
    green = (np.swapaxes(gradient, -1, -2) @ gradient - np.eye(2)) / 2
    values, first = principal(green)
    logarithms = hencky_of(values)
    second = np.stack([-first[..., 1], first[..., 0]], axis=-1)
    axes = np.stack([first, second], axis=-2)
    hencky = np.einsum("...k,...ki,...kj->...ij", logarithms, axes, axes)
    return PlanarStrain(gradient, green, hencky, values, logarithms, window, gauge_px)


def _slopes(windows: Windows, spacing: int) -> tuple[Floats, Ints]:
    """Operators (U, 2, K) of the slopes along x and y, px, and which one each window has."""
    packed = np.packbits(windows.inside, axis=1)
    _, first, pattern = np.unique(packed, axis=0, return_index=True, return_inverse=True)
    inside = windows.inside[first]
    offsets = np.broadcast_to(windows.offsets * float(spacing), (*inside.shape, 2))
    operators = quadratic_operators(offsets, inside)
    return operators[:, 1:3], pattern.reshape(-1).astype(np.int64)
