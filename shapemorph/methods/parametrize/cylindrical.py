"""Cylindrical map: the surface around an axis, unrolled."""

import numpy as np

from shapemorph.core.arrays import Floats, Ints
from shapemorph.core.errors import DataError
from shapemorph.methods.parametrize.frames import (
    directed_areas,
    screen,
    show_outer_side,
    unit,
    vertex_areas,
)
from shapemorph.methods.parametrize.round_fit import fit_round, weighted_median

ROUNDS = 4  # of the axis and its weights
AMBIGUOUS = 4.0  # two directions of curvature are told apart from this ratio of moments on


def parametrise_cylindrical(
    vertices: Floats, faces: Ints, *, centre: Floats | None, axis: Floats | None, name: str
) -> Floats:
    """Unroll an open patch around an axis; it may wind around more than once.

    Parameters
    ----------
    vertices : (V, 3)
    faces : (F, 3)
    centre : (3,) or None
        A point of the axis; None: of the cylinder that fits best.
    axis : (3,) or None
        Direction, up in the picture; None: of the cylinder that fits best, its largest
        coordinate positive.
    name : str
        What errors call the mesh.

    Returns
    -------
    (V, 2)
        In the unit of the vertices, true on the cylinder of the median radius: x is the
        arc, right as seen from the outer side, y the height along the axis; faces
        counter-clockwise.

    Raises
    ------
    DataError
        If the surface closes around the axis.
    """
    weights = vertex_areas(vertices, faces)
    if axis is None:
        along, kept = _fit_axis(vertices, faces, weights)
    else:
        along, kept = unit(axis), weights
    right, up = screen(along)
    frame = np.stack([right, up], axis=1)
    middle = fit_round(vertices @ frame, kept)[0] if centre is None else centre @ frame
    spokes = vertices @ frame - middle
    angle = unwrap_angle(np.arctan2(spokes[:, 1], spokes[:, 0]), faces, name=name)
    angle -= weighted_median(angle, weights)
    radius = weighted_median(np.linalg.norm(spokes, axis=1), weights)
    plane = np.stack([radius * angle, vertices @ along], axis=1)
    return show_outer_side(vertices, faces, plane)


def _fit_axis(vertices: Floats, faces: Ints, weights: Floats) -> tuple[Floats, Floats]:
    """Direction that normals avoid; of what is flat or round both ways, the longest one."""
    normals = directed_areas(vertices, faces)
    area = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(area, np.finfo(float).tiny)[:, None]
    kept = weights
    for _ in range(ROUNDS):
        trust = area * (kept / np.maximum(weights, 1e-300))[faces].min(axis=1)
        moments, directions = np.linalg.eigh((normals * trust[:, None]).T @ normals)
        axis = directions[:, 0]
        if moments[1] < AMBIGUOUS * max(moments[0], 1e-12 * moments[2]):
            axis = _longest(vertices, weights, directions[:, :2])
        right, up = screen(axis)
        _, kept = fit_round(vertices @ np.stack([right, up], axis=1), weights)
    upward: Floats = axis if axis[np.abs(axis).argmax()] > 0 else -axis
    return upward, kept


def _longest(vertices: Floats, weights: Floats, span: Floats) -> Floats:
    """Direction of the two in the columns of `span` along which the points spread most."""
    spread = (vertices - np.average(vertices, axis=0, weights=weights)) @ span
    _, directions = np.linalg.eigh((spread * weights[:, None]).T @ spread)
    longest: Floats = span @ directions[:, 1]
    return longest


def unwrap_angle(angle: Floats, faces: Ints, *, name: str) -> Floats:
    """Continue an angle over a connected mesh without jumps, neighbour by neighbour.

    Parameters
    ----------
    angle : (V,)
        Radians, up to whole turns.
    faces : (F, 3)

    Returns
    -------
    (V,)
        Between neighbours it changes by less than half a turn.

    Raises
    ------
    DataError
        If that is impossible, because the surface closes around the axis.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order

    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    count = len(angle)
    linked = coo_array((np.ones(len(start), np.int8), (start, end)), shape=(count, count)).tocsr()
    order, before = breadth_first_order(linked, 0, directed=False)
    later, parents = order[1:], before[order[1:]]
    steps = np.round((angle[parents] - angle[later]) / (2 * np.pi)).astype(np.int64)
    turns = np.zeros(count, dtype=np.int64)
    for vertex, parent, step in zip(later.tolist(), parents.tolist(), steps.tolist(), strict=True):
        turns[vertex] = turns[parent] + step
    unwrapped: Floats = angle + 2 * np.pi * turns
    jumps = np.abs(unwrapped[end] - unwrapped[start]) > np.pi * (1 + 1e-9)
    if jumps.any():
        raise DataError(
            f"{name}: cylindrical flattening expected an open patch, got a surface that closes "
            "around the axis: cut it along its length, set flatten.axis so that it does not, or "
            "set flatten.method=auto, which cuts it"
        )
    return unwrapped
