"""Where a plane cuts a triangulated surface."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.forming import Cut, Plane


def middle_of(points: Floats, corners: Ints) -> tuple[Floats, Floats]:
    """Find the centroid of a surface and its mean normal.

    Parameters
    ----------
    points : (N, 3)
    corners : (T, 3)

    Returns
    -------
    (3,), (3,)
        mm; the unit vector along the sum of all areas, or the thinnest direction where that
        vanishes (closed surfaces).
    """
    ends = points[corners]
    areas = np.cross(ends[:, 1] - ends[:, 0], ends[:, 2] - ends[:, 0]) / 2
    size = np.linalg.norm(areas, axis=1)
    centre = np.average(ends.mean(axis=1), axis=0, weights=size)
    total = areas.sum(axis=0)
    if np.linalg.norm(total) < 1e-3 * size.sum():
        total = np.linalg.svd(points[np.unique(corners)] - centre, full_matrices=False)[2][2]
    return centre, total / np.linalg.norm(total)


def plane_of(
    middle: tuple[Floats, Floats], point: Floats | None, normal: Floats | None, angle: float
) -> Plane:
    """Settle a plane.

    Parameters
    ----------
    middle : (3,), (3,)
        From :func:`middle_of`.
    point, normal : (3,) or None
        None: the middle; a plane along the mean normal.
    angle : float
        Without a normal: direction of the cut about the mean normal, radians from the x
        axis of the frame (from its y axis where the mean normal is along x).
    """
    centre, axis = middle
    if normal is not None:
        across = normal / np.linalg.norm(normal)
        along = np.cross(axis, across)
        if np.linalg.norm(along) < 1e-6:
            along = np.cross(np.eye(3)[np.abs(across).argmin()], across)
    else:
        first = _in_plane(np.eye(3)[0], axis)
        if np.linalg.norm(first) < 1e-3:
            first = _in_plane(np.eye(3)[1], axis)
        first = first / np.linalg.norm(first)
        along = np.cos(angle) * first + np.sin(angle) * np.cross(axis, first)
        across = np.cross(along, axis)
    return Plane(centre if point is None else point, across, along / np.linalg.norm(along))


def cut_surface(name: str, points: Floats, corners: Ints, plane: Plane) -> Cut:
    """Cut a triangulated surface by a plane.

    Parameters
    ----------
    name : str
    points : (N, 3)
    corners : (T, 3)
        Triangles, no edge shared by more than two.
    plane : Plane

    Returns
    -------
    Cut
        Its lines in order of where they begin, each running along the plane's direction;
        empty where the plane misses the surface.
    """
    side = (points - plane.point) @ plane.normal >= 0
    crossed = corners[(side[corners].any(axis=1)) & ~side[corners].all(axis=1)]
    edges = np.sort(crossed[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
    cut = side[edges[..., 0]] != side[edges[..., 1]]
    unique, number = np.unique(edges[cut], axis=0, return_inverse=True)
    links = number.reshape(-1, 2)  # each crossed triangle has two cut edges
    height = np.abs((points[unique] - plane.point) @ plane.normal)
    share = height[:, 0] / np.maximum(height.sum(axis=1), np.finfo(float).tiny)
    places = points[unique[:, 0]] + share[:, None] * (points[unique[:, 1]] - points[unique[:, 0]])
    lines = _lines(links, (places - plane.point) @ plane.along)
    order = np.concatenate(lines) if lines else np.zeros(0, dtype=np.int64)
    starts = np.zeros(len(order), dtype=bool)
    starts[np.cumsum([0, *map(len, lines)])[:-1]] = True
    return Cut(name, plane, unique[order], share[order], starts)


def _lines(links: Ints, place: Floats) -> list[Ints]:
    """Chain links (L, 2) between nodes into lines, each from its lower end upwards."""
    neighbours: list[list[int]] = [[] for _ in range(len(place))]
    for first, second in links.tolist():
        neighbours[first].append(second)
        neighbours[second].append(first)
    left = set(range(len(place)))
    upwards = np.argsort(place).tolist()
    ends = [node for node in upwards if len(neighbours[node]) == 1]
    starts = (*ends, *upwards)  # open lines first, then closed ones
    lines = [_walk(start, neighbours, left) for start in starts if start in left]
    return sorted(lines, key=lambda line: float(place[line[0]]))


def _walk(start: int, neighbours: list[list[int]], left: set[int]) -> Ints:
    line = [start]
    left.discard(start)
    while following := [node for node in neighbours[line[-1]] if node in left]:
        line.append(following[0])
        left.discard(following[0])
    return np.array(line, dtype=np.int64)


def _in_plane(vector: Floats, normal: Floats) -> Floats:
    inside: Floats = vector - (vector @ normal) * normal
    return inside
