"""Spherical maps: the surface seen from the centre of a ball, laid out around an axis.

The paper's Eq. 5 takes the sine of the polar angle for the radius in the picture, which
collapses on steep walls; these keep lengths along meridians, areas, or angles of the
ball instead (J. P. Snyder, Map projections, U.S. Geological Survey 1395, 1987, chapters
21, 24, 25).
"""

from collections.abc import Callable

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.methods.parametrize.frames import screen, show_outer_side, unit, vertex_areas
from shapemorph.methods.parametrize.orthographic import mean_axis
from shapemorph.methods.parametrize.round_fit import fit_round, weighted_median

RADIUS: dict[str, Callable[[Floats], Floats]] = {
    "equidistant": lambda angle: angle,
    "equal_area": lambda angle: np.asarray(2.0 * np.sin(angle / 2)),
    "stereographic": lambda angle: np.asarray(2.0 * np.tan(angle / 2)),
}
"""Radius in the picture of a unit ball over the angle from its axis."""


def parametrise_spherical(
    vertices: Floats,
    faces: Ints,
    *,
    centre: Floats | None,
    axis: Floats | None,
    projection: str,
) -> Floats:
    """Map a cap, a dome or a ball with a hole around an axis.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
    centre : (3,) or None
        Of the ball; None: of the sphere that fits best.
    axis : (3,) or None
        From the centre to the middle of the picture, any length; None: to the middle of
        the surface, which leads away from its largest hole.
    projection : str
        A key of :data:`RADIUS`.

    Returns
    -------
    (V, 2)
        In the unit of the vertices, true at the middle of the picture on the ball of the
        median radius; x right, y up, faces counter-clockwise.

    Raises
    ------
    DataError
        If the surface covers the point opposite the middle.
    """
    weights = vertex_areas(vertices, faces)
    if centre is None:
        centre, _ = fit_round(vertices, weights)
    spokes = vertices - centre
    distance = np.linalg.norm(spokes, axis=1)
    directions = spokes / np.maximum(distance, np.finfo(float).tiny)[:, None]
    towards = _middle(vertices, faces, directions, weights) if axis is None else unit(axis)
    right, up = screen(towards)
    across = np.stack([directions @ right, directions @ up], axis=1)
    sine = np.linalg.norm(across, axis=1)
    angle = np.arctan2(sine, directions @ towards)
    _refuse_covered_antipode(across / np.maximum(sine, 1e-300)[:, None], angle, faces)
    radius = RADIUS[projection](angle)
    stretch = np.where(sine > 0, radius / np.where(sine > 0, sine, 1.0), 1.0)
    plane = weighted_median(distance, weights) * stretch[:, None] * across
    return show_outer_side(vertices, faces, plane)


def _middle(vertices: Floats, faces: Ints, directions: Floats, weights: Floats) -> Floats:
    """Direction of the middle of the surface; of a full ball none, then of its best plane."""
    mean = weights @ directions / weights.sum()
    if np.linalg.norm(mean) < 1e-6:
        return mean_axis(vertices, faces)
    return unit(mean)


def _refuse_covered_antipode(across: Floats, angle: Floats, faces: Ints) -> None:
    """Raise if a face holds the point of the ball that no such map can show."""
    beyond = across * np.tan((np.pi - np.minimum(angle, np.pi)) / 2)[:, None]
    corners = beyond[faces[(angle[faces] > np.pi / 2).all(axis=1)]]
    ahead = np.roll(corners, -1, axis=1)
    turn = corners[..., 0] * ahead[..., 1] - corners[..., 1] * ahead[..., 0]
    if ((turn >= 0).all(axis=1) | (turn <= 0).all(axis=1)).any():
        raise DataError(
            "spherical flattening: expected a hole opposite the middle of the picture, got a "
            "surface that covers it: set flatten.axis to point away from a hole, or "
            "flatten.method=auto"
        )
