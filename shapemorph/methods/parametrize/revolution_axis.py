"""The axis around which a surface of revolution turns.

References
----------
H. Pottmann, T. Randrup, Rotational and helical surface approximation for reverse
engineering, Computing 60 (1998), doi 10.1007/BF02684378: normals of a surface of
revolution meet its axis.
"""

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.methods.parametrize.frames import directed_areas, screen, unit
from shapemorph.methods.parametrize.round_fit import tukey

ROUNDS = 8
KNOWN = 0.01  # part of the strongest moment below which a motion of the axis is not known
OPEN = 0.02  # vector area over area from which the rim tells the axis


def fit_revolution_axis(
    vertices: Floats, faces: Ints, *, centre: Floats | None, axis: Floats | None
) -> tuple[Floats, Floats]:
    """Find the axis that most normals meet.

    Motions of the axis that the normals leave open (along a plane; around the centre of a
    sphere) keep the start: the centroid, and the normal of the rim.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
    centre : (3,) or None
        A point of the axis if it is known.
    axis : (3,) or None
        Its direction if that is known.

    Returns
    -------
    centre : (3,)
    axis : (3,)
        Unit vector.
    """
    normals = directed_areas(vertices, faces)
    area = np.linalg.norm(normals, axis=1)
    middles = vertices[faces].mean(axis=1)
    start = np.average(middles, axis=0, weights=area)
    size = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    local = (middles - start) / size
    point = np.zeros(3) if centre is None else (centre - start) / size
    along = _first_axis(local, normals, area) if axis is None else unit(axis)
    normals /= np.maximum(area, np.finfo(float).tiny)[:, None]
    free = np.array([axis is None] * 2 + [centre is None] * 2)
    if free.any():
        for _ in range(ROUNDS):
            point, along = _improve(local, normals, area, point, along, free)
    return start + size * point, along


def _first_axis(points: Floats, normals: Floats, area: Floats) -> Floats:
    """Take the normal of the rim; where the rims cancel each other, the odd main axis."""
    total = normals.sum(axis=0)
    if np.linalg.norm(total) > OPEN * area.sum():
        return unit(total)
    moments, directions = np.linalg.eigh((points * area[:, None]).T @ points)
    odd = 0 if moments[1] - moments[0] > moments[2] - moments[1] else 2
    first: Floats = directions[:, odd]
    return first


def _improve(
    points: Floats, normals: Floats, area: Floats, point: Floats, along: Floats, free: Bools
) -> tuple[Floats, Floats]:
    """Take one step of Gauss and Newton on the moments of the normals about the axis."""
    right, up = screen(along)
    moments = np.cross(points - point, normals)
    residuals = moments @ along
    across = np.cross(normals, along)
    slopes = np.stack([moments @ right, moments @ up, -(across @ right), -(across @ up)], axis=1)
    slopes = slopes * free
    weights = area * tukey(residuals) / area.sum()
    strengths, ways = np.linalg.eigh((slopes * weights[:, None]).T @ slopes)
    pull = ways.T @ ((slopes * weights[:, None]).T @ residuals)
    known = strengths > KNOWN * strengths[-1]
    step = -(ways[:, known] @ (pull[known] / strengths[known]))
    turned = unit(along + step[0] * right + step[1] * up)
    return point + step[2] * right + step[3] * up, turned
