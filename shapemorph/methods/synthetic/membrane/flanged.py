"""A blown sheet with the flange that was clamped: smooth maps of it before and after."""

from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from shapemorph.core.arrays import Floats
from shapemorph.core.laws import RadialProfile
from shapemorph.core.spline_map import SplineMap
from shapemorph.methods.synthetic.membrane.disc import disc_mesh
from shapemorph.methods.synthetic.membrane.smooth import fit_map

NODES = 64  # along the radius of the sheet, that the maps are fitted to
KNOTS = 1.6  # of their distance between the coefficients of a map
WAVES = 2  # of the bent flange around the die


def radial_profile(nodes: Floats, radius: float, rings: int) -> RadialProfile:
    """Average the nodes of :func:`disc_mesh` over each ring.

    Parameters
    ----------
    nodes : (N, 3)
        Where they are in space, mm.
    radius : float
        Of the disc, mm.
    rings : int
    """
    ends = [0, *(1 + 3 * ring * (ring + 1) for ring in range(rings + 1))]
    out = np.linalg.norm(nodes[:, :2], axis=1)
    parts = [slice(low, high) for low, high in pairwise(ends)]
    return RadialProfile(
        material=radius * np.arange(rings + 1) / rings,
        radius=np.array([0.0, *(out[part].mean() for part in parts[1:])]),
        height=np.array([nodes[part, 2].mean() for part in parts]),
    )


def flanged_maps(
    profile: RadialProfile, *, edge: float, rounding: float, bend: float
) -> tuple[SplineMap, SplineMap]:
    """Lay smooth maps through a sheet before and after it was blown.

    Parameters
    ----------
    profile : RadialProfile
        Of the blown part, up to the die; beyond lies the flange.
    edge : float
        Radius of the sheet with its flange, mm.
    rounding : float
        Of the material on both sides of the die's edge over which the sheet bends, mm.
    bend : float
        How far the edge of the flange is bent up where it is bent most, mm.

    Returns
    -------
    (SplineMap, SplineMap)
    """
    material, _ = disc_mesh(edge, NODES)
    reach = np.linalg.norm(material, axis=1)
    out, up = _rounded(profile, reach, rounding).T
    angle = np.arctan2(material[:, 1], material[:, 0])
    clamped = profile.material[-1] + rounding
    beyond = np.maximum(reach - clamped, 0.0) / (edge - clamped)
    up = up + bend * beyond**2 * (0.5 + 0.5 * np.cos(WAVES * angle + 0.7))
    after = material * (out / np.maximum(reach, 1e-12))[:, None]
    before = np.column_stack([material, np.zeros(len(material))])
    spacing = KNOTS * edge / NODES
    return (
        fit_map(material, before, spacing=spacing),
        fit_map(material, np.column_stack([after, up]), spacing=spacing),
    )


def _rounded(profile: RadialProfile, reach: Floats, rounding: float) -> Floats:
    """Radius and height (N, 2) at material radii (N,): the curve, a parabola, the flange."""
    die = float(profile.material[-1])
    inner = CubicSpline(profile.material, np.stack([profile.radius, profile.height], axis=1))

    def curve(at: Floats) -> Floats:
        flange = np.stack([profile.radius[-1] + at - die, np.full_like(at, profile.height[-1])], 1)
        return np.where(at[:, None] < die, inner(np.minimum(at, die)), flange)

    start, corner, end = curve(np.array([die - rounding, die, die + rounding]))
    share = ((reach - die + rounding) / (2 * rounding))[:, None]
    bent = (1 - share) ** 2 * start + 2 * share * (1 - share) * corner + share**2 * end
    found: Floats = np.where(np.abs(reach - die)[:, None] < rounding, bent, curve(reach))
    return found
