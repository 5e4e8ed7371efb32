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

ROUNDS = 12
SMOOTHINGS = 8  # of normals and places, each over the faces around
KNOWN = 30.0  # strength over the noise of the moments from which a motion of the axis is known
ROUND_OFF = 1e-8  # of the strongest
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
    local, normals = _smooth(faces, area, local), _smooth(faces, area, normals)
    normals /= np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)[:, None]
    free = np.array([axis is None] * 2 + [centre is None] * 2)
    if free.any():
        for k in range(ROUNDS):
            point, along = _improve(
                local, normals, area, (point, along), free, robust=2 * k >= ROUNDS
            )
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


def _smooth(faces: Ints, area: Floats, values: Floats) -> Floats:
    """Average vectors (F, 3) of faces over their neighbours several times: normals are rough."""
    corner, shares = faces.ravel(), np.repeat(area, 3)
    total = np.maximum(np.bincount(corner, shares), np.finfo(float).tiny)
    for _ in range(SMOOTHINGS):
        spread = np.repeat(values, 3, axis=0) * shares[:, None]
        sums = [np.bincount(corner, spread[:, k]) for k in range(3)]
        values = (np.stack(sums, axis=1) / total[:, None])[faces].mean(axis=1)
    return values


def _improve(
    points: Floats,
    normals: Floats,
    area: Floats,
    axis: tuple[Floats, Floats],
    free: Bools,
    *,
    robust: bool,
) -> tuple[Floats, Floats]:
    """Take one step of Gauss and Newton on the moments of the normals about the axis."""
    point, along = axis
    right, up = screen(along)
    moments = np.cross(points - point, normals)
    residuals = moments @ along
    across = np.cross(normals, along)
    slopes = np.stack([moments @ right, moments @ up, -(across @ right), -(across @ up)], axis=1)
    slopes = slopes * free
    weights = area / area.sum() * (tukey(residuals) if robust else 1.0)
    step = _known_step(slopes, residuals, weights)
    return point + step[2] * right + step[3] * up, unit(along + step[0] * right + step[1] * up)


def _known_step(slopes: Floats, residuals: Floats, weights: Floats) -> Floats:
    """Solve least squares (N, 4), without the directions that noise alone would decide."""
    strengths, ways = np.linalg.eigh((slopes * weights[:, None]).T @ slopes)
    pull = ways.T @ ((slopes * weights[:, None]).T @ residuals)
    real = strengths > ROUND_OFF * strengths[-1]
    full = np.where(real, pull / np.where(real, strengths, 1.0), 0.0)
    left = residuals - slopes @ (ways @ full)
    noise = (weights @ left**2) / max(float(weights.sum()), 1e-300)
    step: Floats = -ways @ np.where(strengths > KNOWN * noise, full, 0.0)
    return step
