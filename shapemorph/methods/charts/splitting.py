"""Split a surface into overlapping patches of similar size."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.methods.charts.graph import edge_graph, nearest_source, rim_vertices

RECENTRINGS = 4


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

    Each face belongs to the centre that is nearest along the surface; each patch is then
    grown into its neighbours.

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
    centres = _spread(graph, faces, count)
    for _ in range(RECENTRINGS):
        centres = _recentred(graph, faces, centres, rim)
    owner = _owner_of_faces(nearest_source(graph, centres)[1], faces)
    return [_grown(graph, faces, owner == k, overlap) for k in range(len(centres))]


def _spread(graph: Any, faces: Ints, count: int) -> Ints:
    """Choose vertices one by one, each as far as possible from all before."""
    used = np.unique(faces)
    start, _ = nearest_source(graph, used[:1])
    chosen = [int(used[start[used].argmax()])]
    for _ in range(count - 1):
        distance, _ = nearest_source(graph, np.array(chosen))
        chosen.append(int(used[distance[used].argmax()]))
    return np.array(chosen, dtype=np.int64)


def _recentred(graph: Any, faces: Ints, centres: Ints, rim: Ints) -> Ints:
    """Move each centre to the vertex of its cell that is farthest from other cells and rims."""
    _, cell = nearest_source(graph, centres)
    border = np.unique(np.concatenate([_between_cells(faces, cell), rim]))
    if len(border) == 0:
        return centres
    depth, _ = nearest_source(graph, border)
    moved = centres.copy()
    for k in range(len(centres)):
        inside = np.flatnonzero((cell == k) & np.isfinite(depth))
        if len(inside):
            moved[k] = inside[depth[inside].argmax()]
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
