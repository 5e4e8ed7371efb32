"""How two cameras stand to each other, from what both see of anything."""

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from shapemorph.core.arrays import Floats
from shapemorph.core.camera import Camera, Rig
from shapemorph.core.errors import StageError
from shapemorph.core.transform import RigidTransform

_MOST_POINTS = 3000
_LEANS = 0.0, -0.2, 0.2  # radians about y: where the search begins
_SCALE = 0.1  # px: residuals beyond it count less
_DEPTHS = 0.05, 1e4  # of the distance of the cameras: where a point may lie


def epipolar_distance(rig: Rig, seen: Floats, matched: Floats) -> Floats:
    """Give the distance (N,) of pixels of the second camera from their epipolar lines, px.

    Parameters
    ----------
    rig : Rig
        Of two cameras.
    seen, matched : (N, 2)
        Pixels of the first and of the second camera.
    """
    first, second = rig.cameras
    motion = rig.between(0, 1)
    one, two = _lifted(first.normalised(seen)), _lifted(second.normalised(matched))
    lines = one @ _essential(motion.rotation, motion.translation).T
    off = (two * lines).sum(axis=1) / np.linalg.norm(lines[:, :2], axis=1)
    distance: Floats = np.abs(off) * float(second.focal.mean())
    return distance


def _lifted(flat: Floats) -> Floats:
    return np.concatenate([flat, np.ones((len(flat), 1))], axis=1)


def _sampson(one: Floats, two: Floats, rotation: Floats, direction: Floats) -> Floats:
    """Give the distance (N,) from the epipolar constraint, to first order, of the unit plane."""
    essential = _essential(rotation, direction)
    lines, back = one @ essential.T, two @ essential
    length = (lines[:, :2] ** 2).sum(axis=1) + (back[:, :2] ** 2).sum(axis=1)
    off: Floats = (two * lines).sum(axis=1) / np.sqrt(length)
    return off


def _essential(rotation: Floats, direction: Floats) -> Floats:
    x, y, z = direction
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ rotation


def orient(first: Camera, second: Camera, seen: Floats, matched: Floats) -> RigidTransform:
    """Find second_from_first from matched pixels; the distance of the cameras is kept.

    Parameters
    ----------
    first, second : Camera
        Their lenses are trusted; where they stand is only the start.
    seen, matched : (N, 2)
        Pixels of the first and of the second camera, px.

    Raises
    ------
    StageError
        If what they see lies before both of them in no way.
    """
    known = np.isfinite(matched).all(axis=1)
    step = max(1, int(known.sum()) // _MOST_POINTS)
    one = _lifted(first.normalised(seen[known][::step]))
    two = _lifted(second.normalised(matched[known][::step]))
    start = Rig((first, second), ("first", "second")).between(0, 1)
    distance = float(np.linalg.norm(start.translation))
    focal = float(second.focal.mean())

    def residuals(turn: Floats) -> Floats:
        return focal * _sampson(one, two, *_moved(start, turn))

    tries = [
        least_squares(residuals, [0.0, lean, 0.0, 0.0, 0.0], loss="soft_l1", f_scale=_SCALE)
        for lean in _LEANS
    ]
    rotation, direction = _moved(start, min(tries, key=lambda found: float(found.cost)).x)
    for sign in (1.0, -1.0):
        if _before_both(one, two, rotation, sign * direction):
            return RigidTransform(rotation, sign * distance * direction)
    raise StageError(
        "the pictures do not tell how the cameras stand to each other: calibrate them again"
    )


def _moved(start: RigidTransform, turn: Floats) -> tuple[Floats, Floats]:
    """Turn a rotation by three angles and the direction of a shift by two."""
    rotation = Rotation.from_rotvec(turn[:3]).as_matrix() @ start.rotation
    direction = start.translation / np.linalg.norm(start.translation)
    side = np.linalg.svd(direction[None])[2][1:]
    moved = direction + turn[3:] @ side
    return rotation, moved / np.linalg.norm(moved)


def _before_both(one: Floats, two: Floats, rotation: Floats, direction: Floats) -> bool:
    """Say whether most points lie before both cameras."""
    turned = one @ rotation.T
    across = np.cross(two, turned)
    square = (across**2).sum(axis=1)
    ahead = -(np.cross(two, direction) * across).sum(axis=1) / square
    depth = ahead * turned[:, 2] + direction[2]
    low, high = _DEPTHS
    sound = (ahead > low) & (ahead < high) & (depth > low)
    return bool(sound.mean() > 0.9)
