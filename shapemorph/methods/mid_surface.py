"""Strain of the middle of a sheet whose skin was measured."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats
from shapemorph.methods.bending import invertible
from shapemorph.methods.grid_windows import connected_windows
from shapemorph.methods.tangent_fit import fit_tangent

_ROUNDS = 6  # thickness and strain depend on each other; each round gains a factor t / R


@dataclass(frozen=True, slots=True, eq=False)
class Curvatures:
    """How both states of a surface bend.

    Attributes
    ----------
    bends : (P, 2, 2, 2) float64
        Second derivatives of the reference and the deformed position (axis 1) along their
        normals, by orthonormal coordinates of the reference tangent plane, 1/mm; NaN
        where a point has none.
    normals : (P, 2, 3) float64
        Those normals.
    gain : (P,) float64
        Standard deviation of a second derivative for heights with independent unit noise,
        1/mm^2.
    """

    bends: Floats
    normals: Floats
    gain: Floats


def curvatures(
    states: tuple[Floats, Floats], reference_px: Floats, usable: Bools, *, window: int, chunk: int
) -> Curvatures:
    """Fit the curvatures of both states around every usable point.

    Parameters
    ----------
    states : two of (P, 3)
        Positions, mm.
    reference_px : (P, 2)
        Grid positions in the reference picture, px.
    usable : (R, C)
        With R C = P.
    window : int
        Points across, odd: curvatures are twice as rough as slopes and want more.
    chunk : int
        Most windows at a time, to bound memory.
    """
    bends, normals = np.full((usable.size, 2, 2, 2), np.nan), np.full((usable.size, 2, 3), np.nan)
    gain = np.full(usable.size, np.nan)
    for windows in connected_windows(usable, window=window, chunk=chunk):
        fit = fit_tangent(*states, reference_px, windows)
        bends[windows.centres] = np.stack(fit.bends, axis=1)
        before = np.cross(fit.tangent[:, 0], fit.tangent[:, 1])
        after = np.cross(fit.gradient[:, :, 0], fit.gradient[:, :, 1])
        length = np.linalg.norm(after, axis=1, keepdims=True)
        after = after / np.where(length > 0, length, np.nan)
        normals[windows.centres] = np.stack([before, after], axis=1)
        gain[windows.centres] = fit.bend_gain
    return Curvatures(bends, normals, gain)


def mid_metric(
    metric: Floats, bends: Floats, sides: Floats, *, thickness: float
) -> tuple[Floats, Floats]:
    """Carry the metric of a skin to the middle of the sheet.

    Parameters
    ----------
    metric : (N, 2, 2)
        C = F^T F of the skin.
    bends : (N, 2, 2, 2)
        From :class:`Curvatures`.
    sides : (N, 2)
        +1 where the sheet lies towards the normals that the bends were taken along, -1
        where it lies against them; reference and deformed.
    thickness : float
        Of the sheet before, mm.

    Returns
    -------
    metric : (N, 2, 2)
        C of the middle, in the same axes.
    offsets : (N, 2)
        From the skin to the middle along the normals, reference and deformed, mm.

    Notes
    -----
    A surface at the distance z has the first fundamental form I - 2 z II + z^2 III. The
    sheet keeps its volume, t = t0 / sqrt(det C); the change of t from place to place
    tilts the middle, which is left out: second order in the slope of t / 2.
    """
    before = np.eye(2) - thickness / 2 * sides[:, 0, None, None] * bends[:, 0]
    into = _inverse(before)
    third = bends[:, 1] @ _inverse(metric) @ bends[:, 1]
    middle: Floats = metric
    offset: Floats = np.zeros(len(metric))
    for _ in range(_ROUNDS):
        now = thickness / np.sqrt(_determinant(middle))
        offset = np.asarray(sides[:, 1] * now / 2, dtype=np.float64)
        z = offset[:, None, None]
        after = metric - 2 * z * bends[:, 1] + z**2 * third
        middle = np.asarray(np.swapaxes(into, 1, 2) @ after @ into, dtype=np.float64)
    return middle, np.stack([sides[:, 0] * thickness / 2, offset], axis=1)


def _inverse(matrices: Floats) -> Floats:
    inverse = np.asarray(np.linalg.inv(invertible(matrices)), dtype=np.float64)
    return np.where(np.isfinite(_determinant(matrices))[:, None, None], inverse, np.nan)


def _determinant(matrices: Floats) -> Floats:
    turns: Floats = matrices[:, 0, 0] * matrices[:, 1, 1] - matrices[:, 0, 1] * matrices[:, 1, 0]
    return np.where(turns > 0, turns, np.nan)
