"""Fill the holes of a surface so that a flattening does not tear around them."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints

MOST_EARS = 128  # vertices of a hole; taking the best ear each time is slow


def loop_length(vertices: Floats, loop: Ints) -> float:
    """Length of a closed loop of vertices, in the unit of the vertices."""
    return float(np.linalg.norm(vertices[np.roll(loop, -1)] - vertices[loop], axis=1).sum())


def order_by_length(vertices: Floats, loops: list[Ints]) -> list[Ints]:
    """Sort boundary loops, the longest first: it is the rim, the others are holes."""
    return sorted(loops, key=lambda loop: -loop_length(vertices, loop))


def fill_holes(vertices: Floats, faces: Ints, holes: list[Ints]) -> tuple[Floats, Ints]:
    """Close holes, each by a fan around the mean of its vertices where that does not fold.

    Ragged holes of up to 128 vertices lose ears one by one instead, the best first, which
    adds no vertex.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
    holes : list of (K,)
        Loops in the direction of the faces along them.

    Returns
    -------
    vertices : (V + fans, 3)
        The given ones first.
    faces : (F + fillers, 3)
        The given ones first.
    """
    centres: list[Floats] = []
    fillers = [faces]
    for hole in holes:
        outline = hole[::-1]
        if len(hole) <= MOST_EARS and _fan_folds(vertices[outline]):
            fillers.append(outline[_clip_ears(_in_own_plane(vertices[outline]))])
        else:
            hub = np.full(len(hole), len(vertices) + len(centres))
            fillers.append(np.stack([outline, np.roll(outline, -1), hub], axis=1))
            centres.append(vertices[hole].mean(axis=0))
    return np.concatenate([vertices, np.reshape(centres, (-1, 3))]), np.concatenate(fillers)


def _fan_folds(outline: Floats) -> bool:
    """Whether some triangle of the fan around the mean lies against the others."""
    spokes = outline - outline.mean(axis=0)
    normals = np.cross(spokes, np.roll(spokes, -1, axis=0))
    return bool((normals @ normals.sum(axis=0) <= 0).any())


def _in_own_plane(outline: Floats) -> Floats:
    """Coordinates (K, 2) in the plane of the area that a loop encloses."""
    spokes = outline - outline.mean(axis=0)
    normal = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    normal /= np.linalg.norm(normal)
    across = np.cross(np.eye(3)[np.abs(normal).argmin()], normal)
    across /= np.linalg.norm(across)
    return np.stack([spokes @ across, spokes @ np.cross(normal, across)], axis=1)


def _clip_ears(outline: Floats) -> Ints:
    """Cut a polygon (K, 2) into K - 2 triangles of its corners, the fattest ear first."""
    left = np.arange(len(outline))
    ears = []
    while len(left) > 3:
        place = int(_ear_quality(outline[left]).argmax())
        ears.append([left[place - 1], left[place], left[(place + 1) % len(left)]])
        left = np.delete(left, place)
    return np.array([*ears, left], dtype=np.int64)


def _ear_quality(outline: Floats) -> Floats:
    """Area over longest side squared of every ear; less for those that hold other corners."""
    before, after = np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0)
    sides = np.stack([outline - before, after - outline, before - after], axis=1)
    longest = (sides**2).sum(axis=2).max(axis=1)
    quality: Floats = _cross(sides[:, 0], sides[:, 1]) / longest
    beside = -1e-9 * float(np.ptp(outline, axis=0).max()) ** 2  # corners on a side are held too
    held = np.ones((len(outline), len(outline)), dtype=bool)
    for start, side in zip((before, outline, after), np.moveaxis(sides, 1, 0), strict=True):
        held &= _cross(side[:, None], outline[None] - start[:, None]) >= beside
    for shift in (-1, 0, 1):
        held[np.arange(len(outline)), (np.arange(len(outline)) + shift) % len(outline)] = False
    return np.where(held.any(axis=1), quality - 2.0, quality)


def _cross(one: Floats, other: Floats) -> Floats:
    product: Floats = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
    return product


def place_hubs(plane: Floats, faces: Ints, count: int) -> Floats:
    """Append the hubs of fans to a flattening, each at the mean of its neighbours.

    Parameters
    ----------
    plane : (V, 2)
    faces : (F, 3)
        Of the filled surface.
    count : int
        Its vertices; those from V on are hubs.
    """
    placed = np.zeros((count, 2))
    placed[: len(plane)] = plane
    for hub in range(len(plane), count):
        around = np.unique(faces[(faces == hub).any(axis=1)])
        placed[hub] = plane[around[around < len(plane)]].mean(axis=0)
    return placed
