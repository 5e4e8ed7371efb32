"""Surface deformation gradient by local least squares on tangent planes."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.methods.bending import bending_cubics, bending_terms, normal_bend
from shapemorph.methods.bending_share import bending_share
from shapemorph.methods.grid_windows import Windows
from shapemorph.methods.least_squares import fit_operators
from shapemorph.methods.quadratic_fit import (
    WORST_CONDITION,
    cubic_changes,
    quadratic_operators,
    quadratics,
)

_STEEPEST = 0.5  # cosine of the largest tilt of a chord from the tangent plane


@dataclass(frozen=True, slots=True, eq=False)
class TangentFit:
    """The deformation around the centres of some windows.

    Attributes
    ----------
    tangent : (N, 2, 3) float64
        Orthonormal basis of the reference tangent plane; the first axis follows the grid
        columns, the second turns from it towards the rows.
    gradient : (N, 3, 2) float64
        d deformed position / d coordinate in `tangent`.
    slopes : (N, 2, K) float64
        Operator of the fit: `slopes @ data` is the gradient, in `tangent`, of anything
        given at the K points of the window.
    mm_per_px : (N,) float64
        Scale of the reference picture there.
    bends : two of (N, 2, 2) float64
        Second derivatives of reference and deformed position along their normals, by
        coordinates in `tangent`, 1/mm.
    bend_gain : (N,) float64
        Standard deviation of one of them for heights with independent unit noise, 1/mm^2.
    misfit : (N, 3, 3) float64
        Sums of products of the components that the fit leaves of the deformed positions
        along their surface, mm^2.
    cubic : (N, 2, 3) float64
        What cubic terms would change in the slopes of the deformed positions, per step of the
        grid along columns and rows, mm; means nothing where the window is not whole.
    """

    tangent: Floats
    gradient: Floats
    slopes: Floats
    mm_per_px: Floats
    bends: tuple[Floats, Floats]
    bend_gain: Floats
    misfit: Floats
    cubic: Floats


@dataclass(frozen=True, slots=True, eq=False)
class _Patch:
    """Points of the windows, relative to their centres."""

    reference: Floats
    deformed: Floats
    inside: Bools


def fit_tangent(
    reference: Floats, deformed: Floats, reference_px: Floats, windows: Windows
) -> TangentFit:
    """Fit the surface deformation gradient at the centre of each window.

    Reference and deformed positions are fitted by quadratics of the coordinates in the
    reference tangent plane (by planes where the points are too few or lie in too narrow a
    strip), and the bending that a quadratic cannot follow is accounted for
    (:func:`~shapemorph.methods.bending.bending_cubics`), unless the points show that space
    was stretched as a whole (:func:`~shapemorph.methods.bending_share.bending_share`).

    Parameters
    ----------
    reference, deformed : (P, 3)
        Positions of all grid points, mm.
    reference_px : (P, 2)
        Grid positions in the reference picture, px.
    windows : Windows
        Indices into these P points.

    Returns
    -------
    TangentFit
        NaN where the points do not settle a plane.

    Notes
    -----
    Exact for a homogeneous stretch of any size, on the fitted tangent plane (of a plane:
    its own); a rigid motion of any surface gives the identity to rounding; otherwise
    second order in the width of the window, and fourth order where a flat sheet only
    bends.
    """
    patch = _gather(reference, deformed, windows)
    picture = _relative(reference_px, windows)
    plane, mm_per_px = _plane(patch, picture)
    return _fit(patch, plane, mm_per_px, cubic_changes(windows.offsets))


def _fit(patch: _Patch, plane: Floats, mm_per_px: Floats, changes: Floats) -> TangentFit:
    """Fit in coordinates of `plane`, then refer everything to the fitted tangent plane."""
    coordinates, inside = _project(patch, plane)
    operators = quadratic_operators(coordinates, inside)
    reference, deformed = operators @ patch.reference, operators @ patch.deformed
    tangent, turn = _orthonormal(_slopes_of(reference))
    back = np.swapaxes(turn, 1, 2)
    slopes = back @ _slopes_of(operators)
    flat = coordinates @ (_slopes_of(reference) @ np.swapaxes(tangent, 1, 2))
    gradient = back @ _slopes_of(deformed)
    bends = [back @ normal_bend(fit) @ turn for fit in (reference, deformed)]
    cubics, shapes = bending_cubics(bends[0], gradient, bends[1]), _cubics(flat)
    bent = patch.deformed - shapes @ np.swapaxes(cubics, 1, 2) @ gradient
    bent = bent - quadratics(coordinates) @ (operators @ bent)
    share, misfit = bending_share(
        coordinates, inside, (patch.reference, patch.deformed), (reference, deformed), bent
    )
    short = bending_terms(cubics, gradient, slopes @ shapes)
    gradient = gradient - share[:, None, None] * short
    gain = np.sqrt(2 * (operators[:, [3, 5]] ** 2).sum(axis=(1, 2)))
    return TangentFit(
        tangent=tangent,
        gradient=np.swapaxes(gradient, 1, 2),
        slopes=slopes,
        mm_per_px=mm_per_px,
        bends=(bends[0], bends[1]),
        bend_gain=gain,
        misfit=misfit,
        cubic=changes @ bent,
    )


def _gather(reference: Floats, deformed: Floats, windows: Windows) -> _Patch:
    return _Patch(_relative(reference, windows), _relative(deformed, windows), windows.inside)


def _relative(points: Floats, windows: Windows) -> Floats:
    """Positions relative to the centre, zero for points that take no part, (N, K, D)."""
    relative: Floats = points[windows.neighbours] - points[windows.centres][:, None]
    return np.where(windows.inside[:, :, None], relative, 0.0)


def _plane(patch: _Patch, picture: Floats) -> tuple[Floats, Floats]:
    """First guess of the tangent plane, and mm per px, from a linear fit over the picture."""
    scale = np.maximum(np.abs(picture).max(axis=(1, 2)), 1.0)[:, None, None]
    terms = np.concatenate([np.ones_like(picture[:, :, :1]), picture / scale], axis=2)
    operators = fit_operators(terms, patch.inside, worst_condition=WORST_CONDITION)
    edges = (operators[:, 1:3] / scale) @ patch.reference
    basis, _ = _orthonormal(edges)
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=-1)
    return basis, np.sqrt(area)


def _project(patch: _Patch, tangent: Floats) -> tuple[Floats, Bools]:
    """Coordinates in the tangent planes, and the points that do not lie too steeply."""
    coordinates = patch.reference @ np.swapaxes(tangent, 1, 2)
    steep = np.linalg.norm(coordinates, axis=2) < _STEEPEST * np.linalg.norm(
        patch.reference, axis=2
    )
    return np.nan_to_num(coordinates), patch.inside & ~steep


def _slopes_of(operators: Floats) -> Floats:
    return operators[:, 1:3]


def _cubics(coordinates: Floats) -> Floats:
    """Cubic monomials x^3, x^2 y, x y^2, y^3, (N, K, 4)."""
    x, y = np.moveaxis(coordinates, 2, 0)
    xx, yy = x * x, y * y
    return np.stack([xx * x, xx * y, x * yy, yy * y], axis=2)


def _orthonormal(edges: Floats) -> tuple[Floats, Floats]:
    """Orthonormalise two vectors (N, 2, 3), keeping the direction of the first.

    Returns the basis (N, 2, 3) and the inverse triangle T (N, 2, 2), so that
    ``basis[j] = sum_i T[i, j] edges[i]``.
    """
    first, second = edges[:, 0], edges[:, 1]
    length = _positive(np.linalg.norm(first, axis=1))
    along = first / length[:, None]
    shear = np.sum(along * second, axis=1)
    rest = second - shear[:, None] * along
    height = _positive(np.linalg.norm(rest, axis=1))
    triangle = np.zeros((len(edges), 2, 2))
    triangle[:, 0, 0] = 1 / length
    triangle[:, 0, 1] = -shear / (length * height)
    triangle[:, 1, 1] = 1 / height
    return np.stack([along, rest / height[:, None]], axis=1), triangle


def _positive(lengths: Floats) -> Floats:
    return np.where(lengths > 0, lengths, np.nan)
