"""Split a surface into overlapping patches of similar size."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.methods.charts.graph import edge_graph, nearest_source, rim_vertices
from shapemorph.methods.parametrize.disk import boundary_loops

RECENTRINGS = 4
DEEP = 0.95  # of the largest distance from the rims


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """Part of a surface.

    Attributes
    ----------
    faces : (M,) int64
        Faces of the surface that it shows.
    home : (M,) bool
        Those of them that no other patch shows better.
    """

    faces: Ints
    home: Bools


def split_surface(vertices: Floats, faces: Ints, *, count: int, overlap: float) -> list[Patch]:
    """Split a connected surface around `count` centres far from each other.

    A surface between several rims, like a tube, is split across them: rings would lie flat
    no better than the whole. Each face belongs to the centre that is nearest along the
    surface; each patch is then grown into its neighbours.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
        One component.
    count : int
    overlap : float
        Distance by which a patch is grown, in the unit of the vertices.
    """
    graph, rim = edge_graph(vertices, faces), rim_vertices(faces)
    inside = _far_inside(graph, faces, rim)
    centres = _spread(graph, inside, count)
    for _ in range(RECENTRINGS):
        centres = _recentred(graph, faces, centres, rim, inside)
    owner = _owner_of_faces(nearest_source(graph, centres)[1], faces)
    return [_grown(graph, faces, owner == k, overlap) for k in range(len(centres))]


def _far_inside(graph: Any, faces: Ints, rim: Ints) -> Ints:
    """Vertices where centres may lie: between several rims, only those far from all."""
    used = np.unique(faces)
    if len(rim) == 0 or len(boundary_loops(faces, name="surface")) < 2:
        return used
    depth = nearest_source(graph, rim)[0][used]
    far: Ints = used[depth >= DEEP * depth.max()]
    return far


def _spread(graph: Any, used: Ints, count: int) -> Ints:
    """Choose some of the vertices one by one, each as far as possible from all before."""
    start, _ = nearest_source(graph, used[:1])
    chosen = [int(used[start[used].argmax()])]
    for _ in range(count - 1):
        distance, _ = nearest_source(graph, np.array(chosen))
        chosen.append(int(used[distance[used].argmax()]))
    return np.array(chosen, dtype=np.int64)


def _recentred(graph: Any, faces: Ints, centres: Ints, rim: Ints, inside: Ints) -> Ints:
    """Move each centre to the allowed vertex of its cell farthest from other cells and rims."""
    _, cell = nearest_source(graph, centres)
    border = np.unique(np.concatenate([_between_cells(faces, cell), rim]))
    if len(border) == 0:
        return centres
    depth, _ = nearest_source(graph, border)
    moved = centres.copy()
    for k in range(len(centres)):
        ours = inside[(cell[inside] == k) & np.isfinite(depth[inside])]
        if len(ours):
            moved[k] = ours[depth[ours].argmax()]
    return moved if len(np.unique(moved)) == len(moved) else centres


def _between_cells(faces: Ints, cell: Ints) -> Ints:
    """Vertices of faces whose corners belong to several cells."""
    cells = cell[faces]
    mixed: Ints = faces[(cells != cells[:, :1]).any(axis=1)].ravel()
    return mixed


def _owner_of_faces(cell: Ints, faces: Ints) -> Ints:
    """Cell that most corners of each face belong to, the first corner's where all differ."""
    first, second, third = cell[faces].T
    owner: Ints = np.where(second == third, second, first)
    return owner


def _grown(graph: Any, faces: Ints, home: Bools, overlap: float) -> Patch:
    near, _ = nearest_source(graph, np.unique(faces[home]))
    shown = np.flatnonzero((near[faces] <= overlap).all(axis=1) | home)
    return Patch(shown, home[shown])
