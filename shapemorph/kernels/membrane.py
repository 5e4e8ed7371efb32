"""Flat triangles of an incompressible membrane in space: energy, forces and stiffness.

With C = F^T F in the plane of a triangle and the thickness that keeps the volume,
I = tr C + 1 / det C - 3, and the energy of a unit of volume is factor (I + shift)^power:
power 1 is neo-Hookean rubber, (m + 1) / 2 one step of a viscous sheet.
"""

import numpy as np
from numba import njit

from shapemorph.core.arrays import Floats, Ints

COLLAPSED = 1e-12


@njit(cache=True)
def _tension_only(s11: float, s22: float, s12: float) -> tuple[float, float, float]:
    """Remove the compressive part of a symmetric 2 x 2 tensor."""
    mean, half = 0.5 * (s11 + s22), np.sqrt(0.25 * (s11 - s22) ** 2 + s12 * s12)
    high, low = mean + half, mean - half
    if low >= 0.0:
        return s11, s22, s12
    if high <= 0.0:
        return 0.0, 0.0, 0.0
    scale = high / (high - low)
    return scale * (s11 - low), scale * (s22 - low), scale * s12


@njit(cache=True)
def membrane_energy(
    x: Floats,
    faces: Ints,
    slopes: Floats,
    volumes: Floats,
    factor: float,
    shift: float,
    power: float,
    forces: Floats,
    blocks: Floats,
    with_blocks: bool,
) -> float:
    """Add forces of all triangles and write their stiffness.

    Parameters
    ----------
    x : (N, 3)
        Nodes, mm.
    faces : (F, 3)
    slopes : (F, 3, 2)
        Gradients of the three shape functions in the plane of the reference triangle, 1/mm.
    volumes : (F,)
        Area times thickness of the reference, mm^3.
    factor, shift, power : float
        Of the energy of a unit of volume, MPa.
    forces : (N, 3)
        The gradient of the energy is added, N.
    blocks : (F, 9, 9)
        Stiffness of each triangle, N/mm, unknown 3 node + component; compression adds
        nothing to its geometric part, so that a slack membrane does not make it indefinite.
    with_blocks : bool
        Whether to write them.

    Returns
    -------
    float
        Energy, N mm; inf where a triangle has collapsed.
    """
    energy = 0.0
    part = np.empty((3, 2))
    change = np.empty((9, 3))
    for f in range(len(faces)):
        part[:] = 0.0
        for a in range(3):
            for i in range(3):
                part[i, 0] += x[faces[f, a], i] * slopes[f, a, 0]
                part[i, 1] += x[faces[f, a], i] * slopes[f, a, 1]
        c11 = part[0, 0] ** 2 + part[1, 0] ** 2 + part[2, 0] ** 2
        c22 = part[0, 1] ** 2 + part[1, 1] ** 2 + part[2, 1] ** 2
        c12 = part[0, 0] * part[0, 1] + part[1, 0] * part[1, 1] + part[2, 0] * part[2, 1]
        det = c11 * c22 - c12 * c12
        if det < COLLAPSED:
            return np.inf
        base = c11 + c22 + 1.0 / det - 3.0 + shift
        volume = volumes[f]
        energy += volume * factor * base**power
        first = volume * factor * power * base ** (power - 1.0)
        # derivative of I by C, and by its off-diagonal once for both places
        d11, d22, d12 = 1.0 - c22 / det**2, 1.0 - c11 / det**2, 2.0 * c12 / det**2
        for a in range(3):
            g0, g1 = slopes[f, a, 0], slopes[f, a, 1]
            for i in range(3):
                p = 3 * a + i
                change[p, 0] = 2.0 * part[i, 0] * g0
                change[p, 1] = 2.0 * part[i, 1] * g1
                change[p, 2] = part[i, 0] * g1 + part[i, 1] * g0
                grown = d11 * change[p, 0] + d22 * change[p, 1] + d12 * change[p, 2]
                forces[faces[f, a], i] += first * grown
        if not with_blocks:
            continue
        second = 0.0
        if power != 1.0:
            second = volume * factor * power * (power - 1.0) * base ** (power - 2.0)
        # second derivatives of 1 / det C
        cube = 2.0 / det**3
        h11, h22 = cube * c22 * c22, cube * c11 * c11
        h1122 = cube * c11 * c22 - 1.0 / det**2
        h12 = 4.0 * cube * c12 * c12 + 2.0 / det**2
        h1112, h2212 = -2.0 * cube * c22 * c12, -2.0 * cube * c11 * c12
        t11, t22, t12 = _tension_only(2 * first * d11, 2 * first * d22, first * d12)
        for p in range(9):
            u11, u22, u12 = change[p, 0], change[p, 1], change[p, 2]
            along = d11 * u11 + d22 * u22 + d12 * u12
            r11 = first * (h11 * u11 + h1122 * u22 + h1112 * u12) + second * d11 * along
            r22 = first * (h1122 * u11 + h22 * u22 + h2212 * u12) + second * d22 * along
            r12 = first * (h1112 * u11 + h2212 * u22 + h12 * u12) + second * d12 * along
            g0, g1 = slopes[f, p // 3, 0], slopes[f, p // 3, 1]
            for q in range(9):
                value = r11 * change[q, 0] + r22 * change[q, 1] + r12 * change[q, 2]
                if p % 3 == q % 3:
                    k0, k1 = slopes[f, q // 3, 0], slopes[f, q // 3, 1]
                    value += g0 * (t11 * k0 + t12 * k1) + g1 * (t12 * k0 + t22 * k1)
                blocks[f, p, q] = value
    return energy


@njit(cache=True)
def add_pressure(
    x: Floats, faces: Ints, pressure: float, forces: Floats, blocks: Floats, with_blocks: bool
) -> float:
    """Add what a pressure on the inner side does: energy -pressure times the volume below.

    Parameters
    ----------
    x, faces, forces, blocks, with_blocks
        As in :func:`membrane_energy`; the pressure acts along the normals of the faces.
    pressure : float
        MPa.

    Returns
    -------
    float
        Energy, N mm.
    """
    total = 0.0
    sixth = pressure / 6.0
    for f in range(len(faces)):
        for a in range(3):
            one, two = faces[f, (a + 1) % 3], faces[f, (a + 2) % 3]
            for i in range(3):
                j, k = (i + 1) % 3, (i + 2) % 3
                area = x[one, j] * x[two, k] - x[one, k] * x[two, j]
                forces[faces[f, a], i] -= sixth * area
                if a == 0:
                    total -= sixth * area * x[faces[f, 0], i]
        if not with_blocks:
            continue
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            for i in range(3):
                j, k = (i + 1) % 3, (i + 2) % 3
                # d2 (x_a . (x_b x x_c)) / d x_a[i] d x_b[j] = x_c[k], and its mirror images
                value = sixth * x[faces[f, c], k]
                blocks[f, 3 * a + i, 3 * b + j] -= value
                blocks[f, 3 * b + j, 3 * a + i] -= value
                value = sixth * x[faces[f, c], j]
                blocks[f, 3 * a + i, 3 * b + k] += value
                blocks[f, 3 * b + k, 3 * a + i] += value
    return total
