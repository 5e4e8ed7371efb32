"""Whether a curved surface was bent, or stretched as a whole."""

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.methods.bending import invertible

_STRETCHED = 1e-2  # odds of stretching, against bending, before the points have spoken
_ROUNDING = 1e-13  # of the size of a window


def bending_share(
    coordinates: Floats,
    inside: Bools,
    points: tuple[Floats, Floats],
    fits: tuple[Floats, Floats],
    bent: Floats,
) -> tuple[Floats, Floats]:
    """Weigh bending against a homogeneous deformation of space, window by window.

    Both change the curvature of a surface and may have one and the same quadratic fit, but
    they go on differently: bending keeps the strain even, an affine map of space lets it
    vary as the tangent plane turns. The points tell them apart: where x = A X + a, they
    lie on no other surface.

    Parameters
    ----------
    coordinates : (N, K, 2)
        Of the points of N windows in some plane, from their centres, mm.
    inside : (N, K)
        Which points take part.
    points : two of (N, K, 3)
        Reference and deformed positions, from those of the centres, mm.
    fits : two of (N, 6, 3)
        Coefficients of 1, x, y, x^2, xy, y^2 of both, by these coordinates.
    bent : (N, K, 3)
        What bending leaves of the deformed positions, mm.

    Returns
    -------
    share : (N,)
        Probability of bending, 0 to 1: 1 / (1 + p (b / a)^(K - 6)), with the sums of
        squares b and a that bending and the affine map leave in the deformed surface and
        the odds p: the likelihoods of both, for noise of unknown size. Next to 1 where
        noise hides which it was.
    left : (N, 3, 3)
        Sums of products of the components of what bending leaves along the deformed
        surface, mm^2; their trace is b.
    """
    normal = _normal(fits[1])
    size = np.where(inside, (coordinates**2).sum(axis=2), 0.0).sum(axis=1)
    floor = _ROUNDING**2 * np.where(size > 0, size, 1.0)
    affine = _squares(_left_by_affine(coordinates, points, fits), inside) + floor
    remainder = np.where(inside[:, :, None], _tangential(bent, normal), 0.0)
    left = np.swapaxes(remainder, 1, 2) @ remainder
    bending = np.trace(left, axis1=1, axis2=2) + floor
    doubt = (inside.sum(axis=1) - 6) * np.log(bending / affine) + np.log(_STRETCHED)
    share: Floats = 1 / (1 + np.exp(np.clip(doubt, -500, 500)))
    return share, left


def _left_by_affine(
    coordinates: Floats, points: tuple[Floats, Floats], fits: tuple[Floats, Floats]
) -> Floats:
    """Subtract the affine map of space that agrees best with both fits, (N, K, 3).

    Along the deformed surface, of the points; across it, of the fitted curvatures alone: a
    surface may have relief finer than the fits.
    """
    before, after = fits
    normals = _normal(before), _normal(after)
    into = _inverse(before[:, 1:3])
    heights = np.einsum("nka,na->nk", before[:, 3:], normals[0])
    carried = after[:, 3:] - before[:, 3:] @ into @ after[:, 1:3]
    steep = np.maximum((heights**2).sum(axis=1), np.finfo(float).tiny)
    thickness = np.einsum("nk,nka->na", heights / steep[:, None], carried)
    place = points[0] - before[:, :1]
    height = np.einsum("nka,na->nk", place, normals[0])
    left = points[1] - after[:, :1] - place @ into @ after[:, 1:3]
    left = left - height[:, :, None] * thickness[:, None]
    uneven = carried - heights[:, :, None] * thickness[:, None]
    across = _squared(coordinates) @ np.einsum("nka,na->nk", uneven, normals[1])[:, :, None]
    remainder: Floats = _tangential(left, normals[1]) + across * normals[1][:, None]
    return remainder


def _inverse(edges: Floats) -> Floats:
    """Carry vectors of a plane (as rows, from the right) to multiples of two of its edges."""
    gram = invertible(edges @ np.swapaxes(edges, 1, 2))
    return np.swapaxes(np.linalg.solve(gram, edges), 1, 2)


def _normal(fit: Floats) -> Floats:
    """Find the unit normal of a fitted surface, zero where it has none, (N, 3)."""
    normal = np.cross(fit[:, 1], fit[:, 2])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    unit: Floats = normal / np.where(length > 0, length, 1.0)
    return unit


def _tangential(vectors: Floats, normal: Floats) -> Floats:
    across = vectors @ normal[:, :, None]
    along: Floats = vectors - across * normal[:, None]
    return along


def _squared(coordinates: Floats) -> Floats:
    """x^2, xy, y^2, (N, K, 3)."""
    x, y = np.moveaxis(coordinates, 2, 0)
    return np.stack([x * x, x * y, y * y], axis=2)


def _squares(vectors: Floats, inside: Bools) -> Floats:
    total: Floats = np.where(inside, (vectors**2).sum(axis=2), 0.0).sum(axis=1)
    return total
