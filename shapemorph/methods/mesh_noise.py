"""Noise of the vertices of a measured surface, from the surface itself."""

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.mesh import TexturedMesh
from shapemorph.methods.least_squares import fit_operators
from shapemorph.methods.vertex_normals import vertex_normals

_MOST_NEIGHBOURS = 60  # of three rings in a regular mesh there are 36
_WORST_CONDITION = 1e9
_CUBIC_TERMS = 10
_ROUGHLY = 300  # vertices: their quantile is known to some 5 %
_SMOOTHEST, _SMOOTHEST_NORMAL = 0.2, -0.8416  # quantile, and that of the unit normal


def vertex_noise(vertices: Floats, faces: Ints, normals: Floats, *, samples: int) -> float:
    """Estimate the standard deviation of one coordinate of a vertex.

    Around a sample of vertices a cubic is fitted to the heights of three rings of
    neighbours over the tangent plane; what it leaves is noise, or relief too fine for a
    cubic (kinks, coarse meshes). A low quantile over the surface takes the noise from its
    smoothest fifth; where the noise itself varies over the surface it is that of the
    quieter parts.

    Parameters
    ----------
    vertices : (V, 3)
        mm.
    faces : (F, 3)
    normals : (V, 3)
        Unit normals of the vertices, calmed over about two edges.
    samples : int
        Vertices to look at, spread evenly over their numbers.

    Returns
    -------
    float
        mm; the noise is taken to be alike in all directions and independent between
        vertices (noise that a scanner's software has smoothed reads too small). 0 where
        the mesh is too small to tell.
    """
    chosen = np.unique(np.linspace(0, len(vertices) - 1, min(samples, len(vertices))).astype(int))
    chosen = chosen[np.isfinite(normals[chosen]).all(axis=1)]
    rings = _three_rings(faces, len(vertices), chosen)
    variances = _residual_variances(vertices, normals, chosen, rings)
    return float(np.sqrt(np.quantile(variances, _SMOOTHEST))) if len(variances) else 0.0


def rough_vertex_noise(mesh: TexturedMesh) -> float:
    """Estimate the noise of the vertices of a mesh from a few of them, mm."""
    normals = vertex_normals(mesh.vertices, mesh.faces, passes=2)
    return vertex_noise(mesh.vertices, mesh.faces, normals, samples=_ROUGHLY)


def _three_rings(faces: Ints, count: int, chosen: Ints) -> sparse.csr_array:
    """Rows of the vertices at most three edges away from the chosen ones."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    ones = np.ones(2 * len(edges), dtype=np.int32)
    ends = np.concatenate([edges, edges[:, ::-1]])
    joined = sparse.csr_array((ones, (ends[:, 0], ends[:, 1])), shape=(count, count))
    rings = joined[chosen]
    for _ in range(2):
        rings = rings + rings @ joined
        rings.data[:] = 1
    return sparse.csr_array(rings)


def _residual_variances(
    vertices: Floats, normals: Floats, chosen: Ints, rings: sparse.csr_array
) -> Floats:
    """Variance of the heights about a cubic, for vertices where it can be told."""
    neighbours, inside = _padded(rings, chosen)
    relative = vertices[neighbours] - vertices[chosen][:, None]
    normal = normals[chosen]
    height = np.einsum("nka,na->nk", relative, normal)
    terms = _cubic(_in_plane(relative, normal), inside)
    operators = fit_operators(terms, inside, worst_condition=_WORST_CONDITION)
    fitted = (terms @ (operators @ height[..., None]))[..., 0]
    residual = np.where(inside, height - fitted, 0.0)
    freedom = inside.sum(axis=1) - _CUBIC_TERMS
    sound = np.isfinite(residual).all(axis=1) & (freedom >= _CUBIC_TERMS // 2)
    variances = (residual[sound] ** 2).sum(axis=1) / freedom[sound]
    corrected: Floats = variances / _low_chi_square(freedom[sound])
    return corrected


def _padded(rings: sparse.csr_array, chosen: Ints) -> tuple[Ints, NDArray[np.bool_]]:
    """Neighbours as a rectangle (N, K), and which entries are real."""
    count = np.minimum(np.diff(rings.indptr), _MOST_NEIGHBOURS)
    width = int(count.max()) if len(count) else 0
    inside = np.arange(width) < count[:, None]
    place = np.where(inside, rings.indptr[:-1, None] + np.arange(width), 0)
    return np.where(inside, rings.indices[place], chosen[:, None]).astype(np.int64), inside


def _in_plane(relative: Floats, normal: Floats) -> Floats:
    """Coordinates in some basis of the plane across each normal, (N, K, 2)."""
    helper = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    basis = np.stack([first, np.cross(normal, first)], axis=2)
    coordinates: Floats = relative @ basis
    return coordinates


def _cubic(coordinates: Floats, inside: NDArray[np.bool_]) -> Floats:
    """Ten monomials up to third degree, in coordinates of order one."""
    squared = np.where(inside, (coordinates**2).sum(axis=2), 0.0).sum(axis=1)
    width = np.sqrt(squared / np.maximum(inside.sum(axis=1), 1))
    x, y = np.moveaxis(coordinates / np.where(width > 0, width, 1.0)[:, None, None], 2, 0)
    terms = [np.ones_like(x), x, y, x * x, x * y, y * y, x**3, x * x * y, x * y * y, y**3]
    return np.stack(terms, axis=2)


def _low_chi_square(freedom: Ints) -> Floats:
    """Low quantile of a chi-square variable over its mean (Wilson and Hilferty, 1931)."""
    spread = 2 / (9 * freedom)
    quantile: Floats = (1 - spread + _SMOOTHEST_NORMAL * np.sqrt(spread)) ** 3
    return quantile
