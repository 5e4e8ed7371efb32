"""Irregular triangulations of one state of a material map, even on that state's own surface."""

from dataclasses import dataclass

import numpy as np

from shapemorph.core.arrays import Bools, Floats, Ints
from shapemorph.kernels.meshing import dither, flip_edges
from shapemorph.methods.synthetic.material import (
    Embedding,
    MaterialMap,
    area_element,
    nearest_on_state,
)

POINT_CORNERS = 64  # of a rim that is a point


@dataclass(frozen=True, slots=True, eq=False)
class MaterialMesh:
    """Triangles on one state that know which material they cover.

    Attributes
    ----------
    vertices : (V, 3) float64
        On the surface, mm, body frame.
    material : (V, 2) float64
        Material coordinates of the vertices, mm.
    faces : (F, 3) int64
        Counter-clockwise in material coordinates.
    nodes : (F, 6, 2) float64
        Material coordinates of the corners and of the middles of the edges 01, 12, 20,
        without the jump where the coordinates close on themselves.
    """

    vertices: Floats
    material: Floats
    faces: Ints
    nodes: Floats


def triangulate(
    material_map: MaterialMap, state: Embedding, *, faces: int, rng: np.random.Generator
) -> MaterialMesh:
    """Cover one state with about `faces` irregular triangles of about equal size.

    Points come from error diffusion of the area of the state, jittered; the Delaunay
    triangulation of the coordinates is flipped until it is Delaunay in space. Rims and kinks
    carry points of their own, so that a fold is not cut across.
    """
    cells, weight, cell = _area_grid(material_map, state, faces)
    spacing = np.sqrt(weight.sum() / faces * 4 / np.sqrt(3))
    rims = [_even_points(loop, state, spacing) for loop in material_map.loops]
    kinks = [_even_points(loop, state, spacing) for loop in material_map.kink_loops]
    fixed = np.concatenate(rims + kinks)
    wanted = 1.03 * (faces / 2 + 0.08 * sum(map(len, rims)) + 0.15 * sum(map(len, kinks)))
    loose = _scatter(cells, weight * (wanted / weight.sum()), cell, rng)
    # Half a spacing off a kink, no circle over one of its edges holds a loose point: the
    # Delaunay triangulation then has all of these edges.
    loose = loose[material_map.inside(loose) & (material_map.kink(loose) > 0.51 * spacing)]
    loose = _keep_apart(loose, fixed, state, spacing)
    material = np.concatenate([fixed, loose])
    rim_count = sum(map(len, rims))
    locked = np.zeros(len(material), dtype=bool)
    locked[rim_count : len(fixed)] = True
    triangles = _delaunay(material_map, state, material, locked, (rim_count, 0.02 * spacing))
    triangles = _spanning(state(material)[0], triangles, spacing)
    used, compact = np.unique(triangles, return_inverse=True)
    material, triangles = material[used], compact.reshape(-1, 3)
    nodes = _nodes(material_map, state, material, triangles)
    return MaterialMesh(state(material)[0], material, triangles, nodes)


def _area_grid(
    material_map: MaterialMap, state: Embedding, faces: int
) -> tuple[Floats, Floats, Floats]:
    """Cells (R, C, 2) over the specimen, the area of the state in each, and the cell size (2,)."""
    span = material_map.upper - material_map.lower
    counts = np.full(2, 128)
    for _ in range(2):
        cell = span / counts
        columns = material_map.lower[0] + cell[0] * (np.arange(counts[0]) + 0.5)
        rows = material_map.lower[1] + cell[1] * (np.arange(counts[1]) + 0.5)
        cells = np.stack(np.meshgrid(columns, rows), axis=-1)
        flat_cells = cells.reshape(-1, 2)
        weight = area_element(state(flat_cells)[1]) * np.prod(cell)
        weight = np.where(material_map.inside(flat_cells), weight, 0.0)
        densest = 0.5 * faces * weight.max() / weight.sum() / np.prod(cell)  # points per mm^2
        counts = np.ceil(span * np.sqrt(densest / 0.25)).astype(np.int64) + 1
    return cells, weight.reshape(cells.shape[:2]), cell


def _scatter(cells: Floats, density: Floats, cell: Floats, rng: np.random.Generator) -> Floats:
    """Material coordinates (N, 2) of points whose number per cell follows `density`."""
    noise = 0.5 + 0.3 * (rng.random(density.shape) - 0.5)
    chosen = cells[dither(density, noise)]
    points: Floats = chosen + cell * (rng.random(chosen.shape) - 0.5)
    return points


def _even_points(loop: Floats, state: Embedding, spacing: float) -> Floats:
    """Points (N, 2) of a closed polygon, evenly spaced on the state.

    Where it shrinks to a point on the state, evenly among the given ones.
    """
    position = state(loop)[0]
    step = np.linalg.norm(np.roll(position, -1, axis=0) - position, axis=1)
    if step.sum() < 1e-6 * spacing:
        return loop[:: max(len(loop) // POINT_CORNERS, 1)]
    reached = np.cumsum(step) - step
    count = max(int(np.ceil(step.sum() / spacing)), 8)
    wanted = np.arange(count) * (step.sum() / count)
    points: Floats = loop[np.unique(np.searchsorted(reached, wanted - 1e-9 * spacing))]
    return points


def _keep_apart(loose: Floats, fixed: Floats, state: Embedding, spacing: float) -> Floats:
    """Drop points that crowd a fixed one or one another on the state."""
    from scipy.spatial import cKDTree

    position = state(loose)[0]
    distance, _ = cKDTree(state(fixed)[0]).query(position)
    apart = distance > 0.5 * spacing
    loose, position = loose[apart], position[apart]
    pairs = cKDTree(position).query_pairs(0.4 * spacing, output_type="ndarray")
    keep = np.ones(len(loose), dtype=bool)
    keep[pairs.max(axis=1)] = False
    return loose[keep]


def _delaunay(
    material_map: MaterialMap,
    state: Embedding,
    material: Floats,
    locked: Bools,
    rim: tuple[int, float],
) -> Ints:
    """Triangles (F, 3) inside the specimen, round in space, counter-clockwise in material.

    `rim` is the number of points on it, which come first, and the width of a sliver, mm.
    """
    from scipy.spatial import Delaunay

    plane = _unrolled(material_map, material)
    hull = Delaunay(plane).simplices.astype(np.int64)
    triangles = _in_order(hull[_is_specimen(material_map, plane, hull, rim)])
    positions = state(material)[0]
    faces, _ = flip_edges(positions, plane, triangles, _neighbours(triangles), locked, 40)
    # Around a tube the second coordinate runs outwards in the plane: a mirror image.
    turned: Ints = faces if material_map.period is None else faces[:, ::-1].copy()
    return turned


def _spanning(positions: Floats, triangles: Ints, spacing: float) -> Ints:
    """Triangles that have an area: where a rim shrinks to a point, some have none."""
    one, other = (positions[triangles[:, k]] - positions[triangles[:, 0]] for k in (1, 2))
    area = np.linalg.norm(np.cross(one, other), axis=1)
    spanning: Ints = triangles[area > 1e-9 * spacing**2]
    return spanning


def _in_order(triangles: Ints) -> Ints:
    """Triangles (F, 3) in an order that depends on their corners alone, not on rounding."""
    first = np.argmin(triangles, axis=1)
    turned = np.take_along_axis(triangles, (first[:, None] + np.arange(3)) % 3, axis=1)
    return turned[np.lexsort(turned.T[::-1])]


def _neighbours(triangles: Ints) -> Ints:
    """Triangle across from each corner (F, 3), -1 at the border."""
    opposite = triangles[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2)
    edges = np.sort(opposite, axis=1)
    order = np.lexsort(edges.T)
    shared = np.flatnonzero((edges[order[1:]] == edges[order[:-1]]).all(axis=1))
    one, other = order[shared], order[shared + 1]
    beside = np.full(len(edges), -1, dtype=np.int64)
    beside[one], beside[other] = other // 3, one // 3
    return beside.reshape(-1, 3)


def _unrolled(material_map: MaterialMap, material: Floats) -> Floats:
    """Plane positions (N, 2) to triangulate: a tube becomes a ring."""
    if material_map.period is None:
        return material
    scale = 2 * np.pi / material_map.period
    angle, reach = material[:, 0] * scale, np.exp((material[:, 1] - material_map.lower[1]) * scale)
    return np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=1)


def _is_specimen(
    material_map: MaterialMap, plane: Floats, triangles: Ints, rim: tuple[int, float]
) -> Bools:
    """Whether triangles (F, 3) of the convex hull lie on the specimen."""
    centre = plane[triangles].mean(axis=1)
    if material_map.period is not None:
        scale = 2 * np.pi / material_map.period
        reach = np.log(np.maximum(np.linalg.norm(centre, axis=1), 1e-9))
        centre = np.stack([np.zeros(len(centre)), material_map.lower[1] + reach / scale], axis=1)
    on_rim = (triangles < rim[0]).all(axis=1)
    outside: Bools = on_rim & (material_map.rim(centre) < rim[1])
    return ~outside


def _nodes(material_map: MaterialMap, state: Embedding, material: Floats, faces: Ints) -> Floats:
    """Material coordinates (F, 6, 2) of corners and of the middles of edges.

    The middle of a chord belongs to the material nearest to it, not to the mean of the
    coordinates of its ends: with it the pattern on a triangle is right to third order.
    """
    corners = material[faces]
    if material_map.period is not None:
        jump = np.round((corners[:, :, 0] - corners[:, :1, 0]) / material_map.period)
        corners = corners - np.stack([jump * material_map.period, np.zeros_like(jump)], axis=-1)
    following = np.roll(corners, -1, axis=1)
    start = (0.5 * (corners + following)).reshape(-1, 2)
    limit = 0.25 * np.linalg.norm(following - corners, axis=-1).ravel()
    ends = state(material)[0][faces]
    chord = (0.5 * (ends + np.roll(ends, -1, axis=1))).reshape(-1, 3)
    middle = nearest_on_state(state, start, chord, steps=3, limit=limit)
    return np.concatenate([corners, middle.reshape(-1, 3, 2)], axis=1)
