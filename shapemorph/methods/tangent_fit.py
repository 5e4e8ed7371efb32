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
    cubics,
    quadratic_operators,
    quadratics,
)
from shapemorph.methods.rim_cubics import PointNoise, with_cubics

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


@dataclass(frozen=True, slots=True, eq=False)
class _Bent:
    """Fits of both states over windows, and what bending makes of them."""

    reference: Floats
    deformed: Floats
    tangent: Floats
    turn: Floats
    slopes: Floats
    gradient: Floats
    bends: tuple[Floats, Floats]
    cubics: Floats
    shapes: Floats
    left: Floats
    share: Floats
    misfit: Floats


def fit_tangent(
    reference: Floats,
    deformed: Floats,
    reference_px: Floats,
    windows: Windows,
    noise: PointNoise | None = None,
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
    noise : PointNoise or None
        Of the deformed positions; given, windows that a rim cuts have cubic terms where
        these say clearly more than noise
        (:func:`~shapemorph.methods.rim_cubics.with_cubics`).

    Returns
    -------
    TangentFit
        NaN where the points do not settle a plane.

    Notes
    -----
    Exact for a homogeneous stretch of any size, on the fitted tangent plane (of a plane:
    its own); a rigid motion of any surface gives the identity to rounding; otherwise
    second order in the width of the window (third at a rim where the positions say clearly
    more than their noise), and fourth order where a flat sheet only bends.
    """
    patch = _gather(reference, deformed, windows)
    picture = _relative(reference_px, windows)
    plane, mm_per_px = _plane(patch, picture)
    coordinates, inside = _project(patch, plane)
    operators = quadratic_operators(coordinates, inside)
    bent = _bent(patch, coordinates, inside, operators)
    cut = np.asarray(~windows.inside.all(axis=1))
    if noise is not None and cut.any():
        straight = patch.deformed - bent.share[:, None, None] * (
            bent.shapes @ np.swapaxes(bent.cubics, 1, 2) @ bent.gradient
        )
        along, _ = _orthonormal(_slopes_of(bent.deformed))
        seen = straight @ np.swapaxes(along, 1, 2)
        operators[cut] = with_cubics(
            coordinates[cut], inside[cut], operators[cut], seen[cut], noise.of(windows, cut)
        )
        bent = _bent(patch, coordinates, inside, operators)
    return _finished(bent, operators, mm_per_px, cubic_changes(windows.offsets))


def _bent(patch: _Patch, coordinates: Floats, inside: Bools, operators: Floats) -> _Bent:
    """Fit in coordinates of a plane, refer it to the fitted tangent plane, weigh bending."""
    reference, deformed = operators @ patch.reference, operators @ patch.deformed
    tangent, turn = _orthonormal(_slopes_of(reference))
    back = np.swapaxes(turn, 1, 2)
    flat = coordinates @ (_slopes_of(reference) @ np.swapaxes(tangent, 1, 2))
    gradient = back @ _slopes_of(deformed)
    bends = [back @ normal_bend(fit) @ turn for fit in (reference, deformed)]
    thirds, shapes = bending_cubics(bends[0], gradient, bends[1]), cubics(flat)
    left = patch.deformed - shapes @ np.swapaxes(thirds, 1, 2) @ gradient
    left = left - quadratics(coordinates) @ (operators @ left)
    share, misfit = bending_share(
        coordinates, inside, (patch.reference, patch.deformed), (reference, deformed), left
    )
    return _Bent(
        reference,
        deformed,
        tangent,
        turn,
        slopes=back @ _slopes_of(operators),
        gradient=gradient,
        bends=(bends[0], bends[1]),
        cubics=thirds,
        shapes=shapes,
        left=left,
        share=share,
        misfit=misfit,
    )


def _finished(bent: _Bent, operators: Floats, mm_per_px: Floats, changes: Floats) -> TangentFit:
    """Take from the gradient what bending has added to it."""
    short = bending_terms(bent.cubics, bent.gradient, bent.slopes @ bent.shapes)
    gradient = bent.gradient - bent.share[:, None, None] * short
    gain = np.sqrt(2 * (operators[:, [3, 5]] ** 2).sum(axis=(1, 2)))
    return TangentFit(
        tangent=bent.tangent,
        gradient=np.swapaxes(gradient, 1, 2),
        slopes=bent.slopes,
        mm_per_px=mm_per_px,
        bends=bent.bends,
        bend_gain=gain,
        misfit=bent.misfit,
        cubic=changes @ bent.left,
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
